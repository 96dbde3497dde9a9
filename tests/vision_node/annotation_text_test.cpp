#include "vision_node/annotation_text.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(AnnotationText, CountsAllThatAFileHas) {
  Annotations annotations;
  annotations.objects = {"peg", "clay"};
  EXPECT_EQ(describe_entries(annotations), "0 strokes, 0 measures");
  annotations.entries = {Stroke{}, Measure{}, Stroke{}};
  EXPECT_EQ(describe_entries(annotations), "2 strokes, 1 measure");
  annotations.put_down = {PutDown{}};
  EXPECT_EQ(describe_entries(annotations), "2 strokes, 1 measure, 1 object put down") << "an object that was put down counts";
  annotations.put_down.push_back({});
  annotations.carved = {{.object = 1, .radius_m = 0.004, .carves = {Carve{}, Carve{}, Carve{}}}};
  EXPECT_EQ(describe_entries(annotations), "2 strokes, 1 measure, 2 objects put down, 3 carves");
}

TEST(AnnotationText, OfMarksHasOnlyThese) {
  EXPECT_EQ(describe_marks({}), "0 strokes, 0 measures");
  EXPECT_EQ(describe_marks({Measure{}}), "0 strokes, 1 measure");
}

}  // namespace
}  // namespace hapton
