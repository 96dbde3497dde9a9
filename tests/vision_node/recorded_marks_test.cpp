#include "vision_node/recorded_marks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "scene/annotations_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

struct RecordedMarksTest : testing::Test {
  RecordedMarksTest() {
    SceneObject lid;
    lid.name = "lid";
    lid.mesh = make_marker(Vec3::Zero(), 0.015);
    lid.is_movable = true;
    SceneObject block = lid;
    block.name = "block";
    block.program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.1});
    scene.objects = {lid, block};
    scene.given_hash = 7;
    view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), {{lid.mesh, {1, 0, 0}}, {block.mesh, {1, 0, 0}}});
  }
  void open(const std::filesystem::path& file) {
    moved.emplace(*view, scene);
    auto opened = RecordedMarks::open(*view, scene, 0.05, file, *moved);
    ASSERT_TRUE(opened) << opened.error().what;
    marks = std::move(*opened);
  }
  std::filesystem::path write_marks() const {
    const Vec3 on_block = scene.objects[1].mesh->vertices[0];
    return folder.write("plan.toml",
                        write_annotations({.objects = {"lid", "block"},
                                           .entries = {Measure{{AnnotationPoint{0, Vec3::Zero()}, AnnotationPoint{1, on_block}}}},
                                           .put_down = {}},
                                          scene.given_hash));
  }
  // Where an end of the measure is in the scene.
  Vec3 end(std::size_t n) const {
    const auto& measure = std::get<Measure>(marks->placed_annotations().entries.at(0));
    return place(measure.ends.at(n), marks->X_SO());
  }

  ScratchFolder folder;
  Scene scene;
  std::unique_ptr<StereoView> view;
  std::optional<MovedObjects> moved;
  std::unique_ptr<RecordedMarks> marks;
};

TEST_F(RecordedMarksTest, AreWhereTheirObjectsAreAtTheMoment) {
  ASSERT_TRUE(view);
  open(write_marks());
  marks->show(0, Pose::Identity());
  const Vec3 at_rest = scene.objects[1].mesh->vertices[0];
  EXPECT_NEAR((end(0) - Vec3::Zero()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((end(1) - at_rest).norm(), 0.0, 1e-9);
  // The lid is put down at another place, and the block is deformed.
  moved->take(ObjectPose{.serial = 1, .object = 0, .p_m = Vec3(0.1, 0, 0)});
  ObjectShape part{.source = 5, .serial = 1, .object = 1};
  part.part.total = static_cast<std::uint32_t>(scene.objects[1].mesh->vertices.size());
  part.part.displacements_m.fill({0.0F, 0.02F, 0.0F});
  for (; part.part.first < part.part.total; part.part.first += ShapePart::kVerticesPerPart) moved->take(part, Arrival::newest);
  moved->take(ShapeStart{.source = 5, .serial = 1, .object = 1, .total = part.part.total, .start_ns = 0, .end_ns = 1000}, Arrival::newest);
  moved->set_time(2000);
  marks->show(2000, Pose::Identity());
  EXPECT_NEAR((end(0) - Vec3(0.1, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((end(1) - at_rest - Vec3(0, 0.02, 0)).norm(), 0.0, 1e-6);
  moved->rewind();
  moved->forget_shapes();
  moved->set_time(0);
  marks->show(0, Pose::Identity());
  EXPECT_NEAR((end(0) - Vec3::Zero()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((end(1) - at_rest).norm(), 0.0, 1e-9) << "back";
}

TEST_F(RecordedMarksTest, WithoutAFileThereAreNone) {
  ASSERT_TRUE(view);
  open({});
  marks->show(0, Pose::Identity());
  EXPECT_TRUE(marks->placed_annotations().entries.empty());
  EXPECT_EQ(marks->X_SO().size(), 2U);
}

TEST_F(RecordedMarksTest, AFileThatIsNotThereIsAnError) {
  ASSERT_TRUE(view);
  moved.emplace(*view, scene);
  const auto opened = RecordedMarks::open(*view, scene, 0.05, folder.path() / "none.toml", *moved);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().what, testing::HasSubstr("none.toml"));
}

}  // namespace
}  // namespace hapton
