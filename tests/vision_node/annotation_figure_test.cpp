#include "vision_node/annotation_figure.h"

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

constexpr double kMarkedBallRadius = 0.03;
constexpr double kInkBound = 5e-5;  // how far a stroke may be from the surface, m

bool is_ink(const std::uint8_t* rgb) { return rgb[2] > 120 && rgb[1] > 90 && rgb[0] * 2 < rgb[2]; }
bool is_measure_line(const std::uint8_t* rgb) { return rgb[0] > 150 && rgb[1] > 150 && rgb[2] > 150; }

// The pixels of one colour in a picture: their number and their mean position.
struct FoundPixels {
  int count = 0;
  Vec2 middle = Vec2::Zero();
};

FoundPixels find_pixels(StereoView& view, bool (*is_wanted)(const std::uint8_t*), int from, int to) {
  view.draw();
  const Picture picture = view.read_picture();
  FoundPixels found;
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = from; x < to; ++x) {
      if (!is_wanted(picture.at(x, y))) continue;
      ++found.count;
      found.middle += Vec2(x - from + 0.5, y + 0.5);
    }
  }
  if (found.count > 0) found.middle /= found.count;
  return found;
}

// A point on the ball: `turn` is its angle about the vertical axis from the side that faces the viewer, `rise` its angle above the equator.
Vec3 on_ball(double turn, double rise) {
  return kMarkedBallRadius * Vec3(std::sin(turn) * std::cos(rise), std::sin(rise), std::cos(turn) * std::cos(rise));
}

struct AnnotationFigureTest : testing::Test {
  void open(StereoMode mode, const std::vector<ShownObject>& objects) {
    view = open_or_fail(plain_settings(mode, mode == StereoMode::side_by_side ? 1280 : 640, 480), objects);
    ASSERT_TRUE(view);
    view->annotation_figure().set_bound(kInkBound);
  }
  void show(std::vector<Annotation> entries) {
    annotations.entries = std::move(entries);
    view->annotation_figure().set_entries(annotations, 2);
  }
  int count_ink() { return find_pixels(*view, is_ink, 0, 640).count; }

  std::unique_ptr<StereoView> view;
  Annotations annotations;
};

TEST_F(AnnotationFigureTest, ADotIsDrawnWhereItIsInBothEyes) {
  open(StereoMode::side_by_side, {});
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(-0.05, 0.03, 0.06), Vec3(0.04, -0.06, -0.08)}) {
    show({Stroke{0, {p}}});
    for (const auto& [eye, from] : {std::pair(Eye::left, 0), std::pair(Eye::right, 640)}) {
      const FoundPixels dot = find_pixels(*view, is_ink, from, from + 640);
      ASSERT_GT(dot.count, 4);
      EXPECT_LT((dot.middle - project_to_pixel(view->screen(), eye, {640, 480}, p)).norm(), 0.8);
    }
  }
}

TEST_F(AnnotationFigureTest, NothingIsDrawnOfAnotherScene) {
  open(StereoMode::mono, {});
  show({Stroke{2, {Vec3::Zero()}}, Stroke{-1, {Vec3::Zero()}}, Measure{{{{0, Vec3::Zero()}, {2, Vec3::UnitX()}}}}});
  EXPECT_EQ(count_ink(), 0);
  EXPECT_TRUE(view->annotation_figure().labels().empty());
}

// The vertices of the stroke lie on the ball, so its segments dip below the surface, by as much as the bound.
TEST_F(AnnotationFigureTest, AStrokeOnARoundSurfaceIsSeenInFullAndHiddenByWhatIsInFront) {
  const auto make_stroke = [&](double turn) {
    Stroke stroke{0, {}};
    const double step = 2.0 * std::acos(1.0 - kInkBound / kMarkedBallRadius);
    for (double rise = -0.5; rise < 0.5; rise += step) stroke.points_m.push_back(on_ball(turn, rise));
    return stroke;
  };
  for (const double turn : {0.0, 0.4, -0.9}) {
    open(StereoMode::mono, {});
    show({make_stroke(turn)});
    const int alone = count_ink();
    ASSERT_GT(alone, 50);
    open(StereoMode::mono, {{make_marker(Vec3::Zero(), kMarkedBallRadius), {1, 0, 0}}});
    show({make_stroke(turn)});
    EXPECT_GT(count_ink(), 0.9 * alone) << turn;
    show({make_stroke(turn + std::numbers::pi)});
    EXPECT_EQ(count_ink(), 0) << "behind the ball";
  }
}

TEST_F(AnnotationFigureTest, AStrokeOnTheBackOfAThinPlateIsHidden) {
  auto plate = std::make_shared<TriangleMesh>();
  plate->vertices = {{-0.05, -0.05, 0}, {0.05, -0.05, 0}, {0.05, 0.05, 0}, {-0.05, 0.05, 0}};
  plate->triangles = {{0, 1, 2}, {0, 2, 3}};
  open(StereoMode::mono, {{plate, {1, 0, 0}}});
  for (const auto& [z, is_seen] : {std::pair(1e-4, true), std::pair(0.0, true), std::pair(-1e-3, false)}) {
    show({Stroke{0, {{-0.02, 0.0, z}, {0.02, 0.01, z}}}});
    EXPECT_EQ(count_ink() > 50, is_seen) << z;
    if (!is_seen) {
      EXPECT_EQ(count_ink(), 0);
    }
  }
}

TEST_F(AnnotationFigureTest, AStrokeGoesWithTheSceneAndItsObject) {
  open(StereoMode::mono, {});
  const Vec3 p(0.01, 0.02, 0.0);
  show({Stroke{1, {p}}});
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  view->annotation_figure().set_scene_pose(X_WS);
  const auto error_px = [&](const Vec3& p_W) {
    return (find_pixels(*view, is_ink, 0, 640).middle - project_to_pixel(view->screen(), Eye::centre, {640, 480}, p_W)).norm();
  };
  EXPECT_LT(error_px(X_WS * p), 0.8);
  Pose X_SO = Pose::Identity();
  X_SO.translation() = Vec3(-0.03, 0.01, 0.02);
  view->annotation_figure().set_objects({Pose::Identity(), X_SO}, -1, Pose::Identity());
  EXPECT_LT(error_px(X_WS * (X_SO * p)), 0.8);
  // The object is picked up: the stroke moves with the stylus.
  Pose X_TO = Pose::Identity();
  X_TO.translation() = Vec3(0.0, -0.03, 0.0);
  view->annotation_figure().set_objects({Pose::Identity(), X_SO}, 1, X_TO);
  ProbeShown probe;
  probe.p_WP = Vec3(0.05, 0.06, -0.02);
  view->annotation_figure().set_probe(probe);
  EXPECT_LT(error_px(probe.p_WP + X_TO * p), 0.8);
}

TEST_F(AnnotationFigureTest, TheStrokeBeingDrawnIsShownUntilItIsDone) {
  open(StereoMode::mono, {});
  const std::vector<Vec3> points = {{-0.02, 0, 0}, {0.02, 0, 0}};
  view->annotation_figure().set_current_stroke(0, &points);
  EXPECT_GT(count_ink(), 50);
  view->annotation_figure().set_current_stroke(-1, nullptr);
  EXPECT_EQ(count_ink(), 0);
}

TEST_F(AnnotationFigureTest, AMeasureHasItsLengthAndShowsThrough) {
  open(StereoMode::mono, {{make_marker(Vec3::Zero(), kMarkedBallRadius), {1, 0, 0}}});
  const Measure across{{{{0, {-0.05, 0, 0}}, {1, {0.05, 0, 0}}}}};
  show({across});
  const auto labels = view->annotation_figure().labels();
  ASSERT_EQ(labels.size(), 1U);
  EXPECT_EQ(labels[0].text, "100.00 mm");
  EXPECT_EQ(labels[0].p_W, Vec3::Zero());
  view->draw();
  const Picture picture = view->read_picture();
  // The line is solid beside the ball. Where the ball is in front of it, every other block of it is drawn.
  const auto drawn_share = [&](double from, double to) {
    const Vec2 a = project_to_pixel(view->screen(), Eye::centre, {640, 480}, {from, 0, 0});
    const Vec2 b = project_to_pixel(view->screen(), Eye::centre, {640, 480}, {to, 0, 0});
    int count = 0;
    int all = 0;
    for (int x = static_cast<int>(a.x()); x < static_cast<int>(b.x()); ++x, ++all) {
      bool is_any = false;
      for (int y = static_cast<int>(a.y()) - 1; y <= static_cast<int>(a.y()) + 1; ++y) is_any = is_any || is_measure_line(picture.at(x, y));
      count += is_any ? 1 : 0;
    }
    return static_cast<double>(count) / all;
  };
  EXPECT_GT(drawn_share(-0.045, -0.033), 0.95);
  EXPECT_NEAR(drawn_share(-0.02, 0.02), 0.5, 0.1);
}

TEST_F(AnnotationFigureTest, AMeasureFollowsItsObjects) {
  open(StereoMode::mono, {});
  show({Measure{{{{0, Vec3::Zero()}, {1, {0.02, 0, 0}}}}}});
  Pose X_SO = Pose::Identity();
  X_SO.translation() = Vec3(0.03, 0, 0);
  view->annotation_figure().set_objects({Pose::Identity(), X_SO}, -1, Pose::Identity());
  ASSERT_EQ(view->annotation_figure().labels().size(), 1U);
  EXPECT_EQ(view->annotation_figure().labels()[0].text, "50.00 mm");
}

TEST_F(AnnotationFigureTest, FromTheFirstEndALineGoesToTheTip) {
  open(StereoMode::mono, {});
  ProbeShown probe;
  probe.p_WP = Vec3(0.03, 0, 0);
  view->annotation_figure().set_first_end(AnnotationPoint{0, Vec3(-0.01, 0, 0)});
  view->annotation_figure().set_probe(probe);
  ASSERT_EQ(view->annotation_figure().labels().size(), 1U);
  EXPECT_EQ(view->annotation_figure().labels()[0].text, "40.00 mm");
  EXPECT_GT(find_pixels(*view, is_measure_line, 0, 640).count, 20);
}

TEST_F(AnnotationFigureTest, TheStrokeBeingDrawnGoesWithTheSceneAndItsObject) {
  open(StereoMode::mono, {});
  Pose X_WS = Pose::Identity();
  X_WS.translation() = Vec3(0.0, 0.03, 0.0);
  Pose X_SO = Pose::Identity();
  X_SO.translation() = Vec3(-0.04, 0.0, 0.0);
  view->annotation_figure().set_scene_pose(X_WS);
  view->annotation_figure().set_objects({X_SO}, -1, Pose::Identity());
  const std::vector<Vec3> dot = {{0.01, 0.0, 0.0}};
  view->annotation_figure().set_current_stroke(0, &dot);
  const FoundPixels found = find_pixels(*view, is_ink, 0, 640);
  ASSERT_GT(found.count, 4);
  EXPECT_LT((found.middle - project_to_pixel(view->screen(), Eye::centre, {640, 480}, X_WS * (X_SO * dot[0]))).norm(), 0.8);
}

TEST_F(AnnotationFigureTest, AMeasureIsDrawnBetweenItsEndsWhereTheSceneIsNow) {
  open(StereoMode::mono, {});
  const Vec3 from(-0.02, 0.01, 0.0);
  const Vec3 to(0.04, 0.01, 0.0);
  show({Measure{{{{0, from}, {1, to}}}}});
  Pose X_WS = Pose::Identity();
  X_WS.translation() = Vec3(0.01, -0.05, 0.0);
  view->annotation_figure().set_scene_pose(X_WS);
  const Vec3 middle = X_WS * Vec3(0.5 * (from + to));
  const auto labels = view->annotation_figure().labels();
  ASSERT_EQ(labels.size(), 1U);
  EXPECT_LT((labels[0].p_W - middle).norm(), 1e-12);
  const FoundPixels line = find_pixels(*view, is_measure_line, 0, 640);
  ASSERT_GT(line.count, 50);
  EXPECT_LT((line.middle - project_to_pixel(view->screen(), Eye::centre, {640, 480}, middle)).norm(), 1.0);
}

TEST_F(AnnotationFigureTest, AMeasureOfTheHeldObjectFollowsTheStylus) {
  open(StereoMode::mono, {});
  show({Measure{{{{0, Vec3::Zero()}, {1, Vec3::Zero()}}}}});
  Pose X_TO = Pose::Identity();
  X_TO.translation() = Vec3(0.0, -0.01, 0.0);
  view->annotation_figure().set_objects({Pose::Identity(), Pose::Identity()}, 1, X_TO);
  ProbeShown probe;
  probe.p_WP = Vec3(0.03, 0.01, 0.0);
  view->annotation_figure().set_probe(probe);
  const auto labels = view->annotation_figure().labels();
  ASSERT_EQ(labels.size(), 1U);
  EXPECT_EQ(labels[0].text, "30.00 mm") << "from the origin to the object in the hand";
  EXPECT_LT((labels[0].p_W - Vec3(0.015, 0.0, 0.0)).norm(), 1e-12);
}

TEST_F(AnnotationFigureTest, OfManyMeasuresTheNewestTwelveHaveLabels) {
  open(StereoMode::mono, {});
  std::vector<Annotation> entries;
  for (int i = 1; i <= 15; ++i) entries.push_back(Measure{{{{0, Vec3::Zero()}, {1, {0.001 * i, 0.0, 0.0}}}}});
  show(entries);
  const auto labels = view->annotation_figure().labels();
  ASSERT_EQ(labels.size(), 12U);
  EXPECT_EQ(labels.front().text, "15.00 mm");
  EXPECT_EQ(labels.back().text, "4.00 mm");
}

TEST_F(AnnotationFigureTest, TheLabelOfABegunMeasureIsInItsMiddle) {
  open(StereoMode::mono, {});
  ProbeShown probe;
  probe.p_WP = Vec3(0.03, 0.02, 0.0);
  view->annotation_figure().set_first_end(AnnotationPoint{0, Vec3(-0.01, 0.02, 0.0)});
  EXPECT_TRUE(view->annotation_figure().labels().empty()) << "no tip is known";
  view->annotation_figure().set_probe(probe);
  ASSERT_EQ(view->annotation_figure().labels().size(), 1U);
  EXPECT_LT((view->annotation_figure().labels()[0].p_W - Vec3(0.01, 0.02, 0.0)).norm(), 1e-12);
  EXPECT_GT(find_pixels(*view, is_measure_line, 0, 640).count, 0);
  view->annotation_figure().set_first_end(std::nullopt);
  EXPECT_TRUE(view->annotation_figure().labels().empty());
  EXPECT_EQ(find_pixels(*view, is_measure_line, 0, 640).count, 0) << "the line is gone, too";
}

TEST(DescribeLength, HasAUnitThatSuits) {
  EXPECT_EQ(describe_length(0.0), "0.00 mm");
  EXPECT_EQ(describe_length(0.0423149), "42.31 mm");
  EXPECT_EQ(describe_length(12.5), "12.5000 m");
  EXPECT_EQ(describe_length(1.0), "1.0000 m");
  EXPECT_EQ(describe_length(1e-4), "0.10 mm");
  EXPECT_EQ(describe_length(3.21e-6), "3.21 um");
}

}  // namespace
}  // namespace hapton
