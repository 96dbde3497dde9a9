#include "core/geometry/inside_out.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, double scale, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v = scale * v + by;
  return mesh;
}

TriangleMesh combined(TriangleMesh one, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) one.triangles.push_back({first + a, first + b, first + c});
  return one;
}

void expect_bodies(const TriangleMesh& mesh, std::size_t count, std::size_t inside_out) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const ClosedBodies bodies = count_closed_bodies(moved(mesh, scale, scale * Vec3(50, -70, 30)));
    EXPECT_EQ(bodies.count, count) << scale;
    EXPECT_EQ(bodies.inside_out, inside_out) << scale;
  }
}

TEST(InsideOut, FindsTheTrianglesOfBodiesWithTheirFrontsOutside) {
  TriangleMesh open = make_icosphere(1.0, 0);
  open.triangles.pop_back();
  const TriangleMesh ball = moved(make_icosphere(1.0, 0), 1.0, Vec3(5, 0, 0));
  const TriangleMesh flipped = turned_inside_out(moved(make_icosphere(1.0, 0), 1.0, Vec3(-5, 0, 0)));
  const std::vector<bool> outward = find_outward_triangles(combined(combined(open, ball), flipped));
  ASSERT_EQ(outward.size(), 59U);  // 19 of the open mesh, 20 of the ball, 20 of the flipped one
  for (std::size_t t = 0; t < outward.size(); ++t) EXPECT_EQ(outward[t], t >= 19 && t < 39) << t;
}

TEST(InsideOut, CountsThePiecesThatAreNoClosedBody) {
  TriangleMesh open = make_icosphere(1.0, 1);
  open.triangles.pop_back();
  const TriangleMesh ball = moved(make_icosphere(1.0, 1), 1.0, Vec3(5, 0, 0));
  EXPECT_EQ(count_closed_bodies(ball).others, 0U);
  EXPECT_EQ(count_closed_bodies(open).others, 1U);
  const ClosedBodies both = count_closed_bodies(combined(ball, open));
  EXPECT_EQ(both.count, 1U);
  EXPECT_EQ(both.others, 1U);
  TriangleMesh lonely = ball;
  lonely.vertices.emplace_back(9, 9, 9);
  EXPECT_EQ(count_closed_bodies(lonely).others, 0U) << "a vertex without triangles is not a piece";
}

TEST(InsideOut, DistinguishesAClosedBodyFromAFlippedOne) {
  const TriangleMesh ball = make_icosphere(1.0, 2);
  expect_bodies(ball, 1, 0);
  expect_bodies(turned_inside_out(ball), 1, 1);
}

TEST(InsideOut, ExaminesEachBodySeparately) {
  const TriangleMesh ball = make_icosphere(1.0, 2);
  // In a sum over both, the large ball would outweigh the small flipped one.
  expect_bodies(combined(moved(ball, 10.0, Vec3(20, 0, 0)), turned_inside_out(ball)), 2, 1);
  expect_bodies(combined(turned_inside_out(ball), moved(turned_inside_out(ball), 2.0, Vec3(0, 9, 0))), 2, 2);
  const TriangleMesh both = combined(turned_inside_out(ball), moved(turned_inside_out(ball), 2.0, Vec3(0, 9, 0)));
  EXPECT_LT((count_closed_bodies(both).inside_out_at - Vec3(0, 9, 0)).norm(), 0.2) << "the larger one";
  EXPECT_EQ(count_closed_bodies(ball).inside_out_at, Vec3(0, 0, 0));
}

// If it joined them, neither the count nor find_outward_triangles would show that one of the balls is flipped.
TEST(InsideOut, ATriangleWithAVertexTwiceJoinsNoBodies) {
  const TriangleMesh ball = make_icosphere(1.0, 0);
  TriangleMesh both = combined(moved(ball, 3.0, Vec3::Zero()), turned_inside_out(moved(ball, 1.0, Vec3(5, 0, 0))));
  const auto second_ball = static_cast<std::uint32_t>(ball.vertices.size());
  for (const Triangle& joining :
       {Triangle{0, 0, second_ball}, Triangle{0, second_ball, second_ball}, Triangle{second_ball, 0, second_ball}}) {
    both.triangles.push_back(joining);
    expect_bodies(both, 2, 1);
    EXPECT_EQ(count_closed_bodies(both).others, 0U);
    const std::vector<bool> outward = find_outward_triangles(both);
    for (std::size_t t = 0; t < 40; ++t) EXPECT_EQ(outward[t], t < 20) << t;
  }
}

TEST(InsideOut, CountsACavityAsABodyThatIsNotInsideOut) {
  const TriangleMesh ball = make_icosphere(1.0, 2);
  expect_bodies(combined(ball, moved(turned_inside_out(ball), 0.5, Vec3::Zero())), 2, 0);
  expect_bodies(combined(turned_inside_out(ball), moved(ball, 0.5, Vec3::Zero())), 2, 1);
}

// A grid of balls with a cavity each, and of balls between them that are inside out. Comparing each with all would take thousands per body.
TEST(InsideOut, TheWorkIsNearLinearInTheBodies) {
  const TriangleMesh ball = make_icosphere(1.0, 0);
  for (const std::size_t side : {8U, 16U, 32U}) {
    TriangleMesh all;
    for (std::size_t i = 0; i < side; ++i) {
      TriangleMesh row;
      for (std::size_t k = 0; k < side; ++k) {
        const Vec3 at(4.0 * static_cast<double>(i), 4.0 * static_cast<double>(k), 0.0);
        row = combined(combined(row, moved(ball, 1.0, at)), moved(turned_inside_out(ball), 0.5, at));
        row = combined(row, moved(turned_inside_out(ball), 0.3, at + Vec3(2, 0, 0)));
      }
      all = combined(std::move(all), row);
    }
    const ClosedBodies bodies = count_closed_bodies(all);
    EXPECT_EQ(bodies.count, 3 * side * side);
    EXPECT_EQ(bodies.inside_out, side * side);
    EXPECT_LT(bodies.comparisons, 20 * bodies.count) << side;
  }
}

// Only a body with its front outside can have a cavity; without one, no body needs to be compared.
TEST(InsideOut, OfBodiesThatAreAllInsideOutNoneIsCompared) {
  TriangleMesh all;
  const TriangleMesh ball = turned_inside_out(make_icosphere(1.0, 0));
  for (int i = 0; i < 100; ++i) all = combined(std::move(all), moved(ball, 1.0 + 0.01 * i, Vec3(3.0 * i, 0, 0)));
  const ClosedBodies bodies = count_closed_bodies(all);
  EXPECT_EQ(bodies.inside_out, 100U);
  EXPECT_EQ(bodies.comparisons, 0U);
  EXPECT_LT((bodies.inside_out_at - Vec3(297, 0, 0)).norm(), 1e-9) << "the largest";
}

TEST(InsideOut, CountsNoBodyThatIsNotClosed) {
  TriangleMesh open = turned_inside_out(make_icosphere(1.0, 2));
  open.triangles.pop_back();
  expect_bodies(open, 0, 0);
  expect_bodies(turned_inside_out(make_plane_grid(1.0, 4)), 0, 0);
  TriangleMesh sheets = combined(make_plane_grid(1.0, 4), TriangleMesh());
  for (const Triangle& t : std::vector<Triangle>(sheets.triangles)) sheets.triangles.push_back({t[0], t[2], t[1]});
  expect_bodies(sheets, 0, 0);
  expect_bodies({}, 0, 0);
}

}  // namespace
}  // namespace hapton
