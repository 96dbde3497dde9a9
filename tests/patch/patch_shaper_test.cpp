#include "patch/patch_shaper.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/patch/chain_stage.h"

namespace hapton {
namespace {

constexpr std::uint32_t kSkin = 1;
constexpr std::int64_t kShaperNsPerMs = 1'000'000;

// A sheet that a program deforms, above a floor. All parts have been received; `shaper` makes the patches of the sheet.
struct PatchShaperTest : testing::Test {
  PatchShaperTest() {
    TouchScene scene;
    scene.objects.push_back({made::shared(made::sheet(0.05, 0.0, 4)), {.stiffness_n_per_m = 800.0}});
    scene.objects.push_back({made::shared(made::sheet(0.02, 0.007, 6)), {.stiffness_n_per_m = 800.0}});
    scene.objects.back().stream_reach_m = 0.006;
    for (const Message& part : parts_of(make_tiles(on_patch_grid(scene)))) (void)store.accept_part(part);
    vertex_count = static_cast<std::uint32_t>(scene.objects.back().mesh->vertices.size());
    piece = store.make_piece(Vec3::Zero(), 1.0, 1, kSkin);
    parts = store.find_stream(kSkin);
  }

  // Announces a shape: within 10 ms the whole sheet rises to z_m above its rest.
  void announce(std::uint32_t serial, std::int64_t start_ms, float z_m) {
    const std::vector<ShapePart::Displacement> shape(vertex_count, {0.0F, 0.0F, z_m});
    for (std::uint32_t first = 0; first < vertex_count; first += ShapePart::kVerticesPerPart) {
      (void)store.accept_shape(ObjectShape{.source = 5, .serial = serial, .object = 1, .part = make_shape_part(shape, first)},
                               Arrival::newest);
    }
    (void)store.accept_shape(ShapeStart{.source = 5,
                                        .serial = serial,
                                        .before = serial - 1,
                                        .object = 1,
                                        .total = vertex_count,
                                        .start_ns = start_ms * kShaperNsPerMs,
                                        .end_ns = (start_ms + 10) * kShaperNsPerMs},
                             Arrival::newest);
  }
  Result<std::unique_ptr<StreamedMethod>> make(std::int64_t time_ms, const KnownShapes& shapes) {
    return shaper.make({}, piece.scene.objects.front(), *parts, shapes, time_ms * kShaperNsPerMs);
  }
  std::unique_ptr<PatchShape> next(std::int64_t time_ms) { return shaper.make_next(*parts, store.shapes(), time_ms * kShaperNsPerMs); }

  PatchStore store;
  PatchStore::Piece piece;
  const StreamedParts* parts = nullptr;
  std::uint32_t vertex_count = 0;
  PatchShaper shaper;
};

TEST_F(PatchShaperTest, MakesTheStagesThatAreAnnouncedOneAfterTheOther) {
  ASSERT_NE(parts, nullptr);
  EXPECT_EQ(shaper.number(), 0U);
  announce(1, 100, 0.001F);
  EXPECT_EQ(next(50), nullptr) << "there is no patch yet";
  const auto method = make(50, store.shapes());
  ASSERT_TRUE(method) << method.error().what;
  ASSERT_NE(*method, nullptr);
  EXPECT_EQ(shaper.number(), 1U);
  announce(2, 120, 0.002F);
  announce(3, 140, 0.003F);
  for (std::uint32_t serial = 2; serial <= 3; ++serial) {
    const auto shape = next(50);
    if (shape == nullptr) {
      ADD_FAILURE() << serial;
      continue;
    }
    EXPECT_EQ(shape->patch, 1U);
    EXPECT_EQ(shape->start_ns, (80 + 20 * serial) * kShaperNsPerMs);
    EXPECT_EQ(shape->end_ns, (90 + 20 * serial) * kShaperNsPerMs);
    ASSERT_FALSE(shape->stage->to.empty());
    for (std::size_t v = 0; v < shape->stage->to.size(); ++v) {
      EXPECT_NEAR(shape->stage->begin[v].z(), 0.007 + 0.001 * (serial - 1), 1e-7);
      EXPECT_NEAR(shape->stage->to[v].z(), 0.007 + 0.001 * serial, 1e-7);
    }
  }
  EXPECT_EQ(next(50), nullptr) << "no further shape was announced";
}

// After make() gave no patch, there is no stage: neither for that patch nor for the one before, which it was to replace.
TEST_F(PatchShaperTest, AfterAPatchThatCannotBeMadeThereIsNoStage) {
  ASSERT_NE(parts, nullptr);
  announce(1, 100, 0.001F);
  announce(2, 120, 0.002F);
  ASSERT_TRUE(make(125, store.shapes()));
  announce(3, 140, 0.003F);
  const auto unknown = make(125, KnownShapes());
  ASSERT_TRUE(unknown) << unknown.error().what;
  EXPECT_EQ(*unknown, nullptr) << "no shape is known";
  EXPECT_EQ(shaper.number(), 1U) << "no patch was made";
  EXPECT_EQ(next(125), nullptr);
  ASSERT_TRUE(make(125, store.shapes()));
  EXPECT_EQ(shaper.number(), 2U);
  const auto shape = next(125);
  ASSERT_NE(shape, nullptr);
  EXPECT_EQ(shape->patch, 2U);
  EXPECT_EQ(shape->start_ns, 140 * kShaperNsPerMs);
  shaper.forget();
  announce(4, 160, 0.004F);
  EXPECT_EQ(next(125), nullptr) << "it was forgotten";
}

}  // namespace
}  // namespace hapton
