#include "scene/annotations_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "scene/mesh_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::uint64_t kAnnotatedHash = 0xFEDCBA9876543210;
const std::vector<std::string> kAnnotatedNames = {"lid", "box", "lid"};

Annotations make_annotations() {
  Annotations annotations;
  annotations.objects = kAnnotatedNames;
  annotations.entries = {Stroke{1, {{0.1, -0.2, 1.0 / 3.0}, {1e-9, 5e-324, -0.0}, {123456.789, 2, 3}}},
                         Measure{{{{0, {0.25, 0, 1}}, {2, {1.0 / 7.0, 0, -1}}}}}, Stroke{2, {{1, 2, 3}}}};
  annotations.put_down = {{2, {0.1, 0.2, 0.3}, Quat(0.5, -0.5, 0.5, 0.5)}};
  return annotations;
}

bool same_annotations(const Annotations& a, const Annotations& b) {
  if (a.objects != b.objects || a.entries.size() != b.entries.size() || a.put_down.size() != b.put_down.size()) return false;
  for (std::size_t i = 0; i < a.entries.size(); ++i) {
    if (a.entries[i].index() != b.entries[i].index()) return false;
  }
  const auto list = [](const Annotations& from) {
    std::pair<std::vector<Stroke>, std::vector<Measure>> lists;
    for (const Annotation& entry : from.entries) {
      if (const auto* stroke = std::get_if<Stroke>(&entry)) lists.first.push_back(*stroke);
      if (const auto* measure = std::get_if<Measure>(&entry)) lists.second.push_back(*measure);
    }
    return lists;
  };
  const auto [strokes_a, measures_a] = list(a);
  const auto [strokes_b, measures_b] = list(b);
  if (strokes_a.size() != strokes_b.size()) return false;
  for (std::size_t i = 0; i < strokes_a.size(); ++i) {
    if (strokes_a[i].object != strokes_b[i].object || strokes_a[i].points_m != strokes_b[i].points_m) return false;
  }
  for (std::size_t i = 0; i < measures_a.size(); ++i) {
    for (std::size_t e = 0; e < 2; ++e) {
      if (measures_a[i].ends[e].object != measures_b[i].ends[e].object || measures_a[i].ends[e].p_O != measures_b[i].ends[e].p_O)
        return false;
    }
  }
  for (std::size_t i = 0; i < a.put_down.size(); ++i) {
    if (a.put_down[i].object != b.put_down[i].object || a.put_down[i].p_m != b.put_down[i].p_m ||
        a.put_down[i].q.coeffs() != b.put_down[i].q.coeffs())
      return false;
  }
  return true;
}

std::string annotations_error(const std::string& text) {
  const auto read = parse_annotations(text, kAnnotatedNames, kAnnotatedHash);
  return read ? "it was read" : read.error().what;
}

TEST(AnnotationsFile, RoundTripIsExact) {
  const Annotations annotations = make_annotations();
  const auto read = parse_annotations(write_annotations(annotations, kAnnotatedHash), kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_TRUE(same_annotations(read->annotations, annotations));
  EXPECT_EQ(read->left_out, 0U);
  EXPECT_FALSE(read->is_other_scene);
  EXPECT_THAT(read->describe_misfit(), IsEmpty());
}

TEST(AnnotationsFile, RoundTripOfAnyNumbersIsExact) {
  constexpr std::uint64_t kSeed = 5;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 200; ++round) {
    Annotations made;
    made.objects = kAnnotatedNames;
    const auto draw_number = [&] {
      return std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())), -44 - static_cast<int>(random() % 200));
    };
    for (int i = 0; i < 5; ++i) {
      Stroke stroke{static_cast<std::int32_t>(random() % 3), {}};
      for (std::size_t k = 0; k < 1 + random() % 4; ++k) stroke.points_m.emplace_back(draw_number(), draw_number(), draw_number());
      made.entries.emplace_back(stroke);
    }
    const auto read = parse_annotations(write_annotations(made, kAnnotatedHash), kAnnotatedNames, kAnnotatedHash);
    ASSERT_TRUE(read) << read.error().what;
    ASSERT_TRUE(same_annotations(read->annotations, made)) << round;
  }
}

TEST(AnnotationsFile, ObjectsAreFoundByTheirNames) {
  Annotations other = make_annotations();
  other.objects = {"lid", "something else", "lid"};
  const auto read = parse_annotations(write_annotations(other, kAnnotatedHash + 1), kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_TRUE(read->is_other_scene);
  EXPECT_EQ(read->left_out, 1U);
  EXPECT_THAT(read->describe_misfit(), HasSubstr("1 of 4 entries"));
  EXPECT_THAT(read->annotations.objects, ElementsAre("lid", "box", "lid", "something else"));
  EXPECT_EQ(std::get<Stroke>(read->annotations.entries[0]).object, 3) << "kept, but of no object of the scene";
  EXPECT_EQ(std::get<Stroke>(read->annotations.entries[2]).object, 2) << "the second lid is the second lid";
  // The entry without an object in this scene is kept when the file is written again, and fits the scene that has the object.
  const auto again =
      parse_annotations(write_annotations(read->annotations, kAnnotatedHash), std::vector<std::string>{"something else"}, kAnnotatedHash);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(std::get<Stroke>(again->annotations.entries[0]).object, 0);
}

TEST(AnnotationsFile, AnotherVersionOfTheSceneIsNoticed) {
  const auto read = parse_annotations(write_annotations(make_annotations(), kAnnotatedHash + 1), kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->left_out, 0U);
  EXPECT_THAT(read->describe_misfit(), HasSubstr("another version"));
}

TEST(AnnotationsFile, AnyNameIsKept) {
  const std::vector<std::string> names = {"a\"b\\c\n\x01\x7F", "\xC3\xA4 \xE2\x82\xAC", "latin \xE4 \xFF\xED\xA0\x80", "", "]#[["};
  Annotations made;
  made.objects = names;
  for (std::int32_t i = 0; i < 5; ++i) made.entries.emplace_back(Stroke{i, {{0, 0, 0}}});
  const auto read = parse_annotations(write_annotations(made, kAnnotatedHash), names, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->left_out, 0U);
  for (std::int32_t i = 0; i < 5; ++i) EXPECT_EQ(std::get<Stroke>(read->annotations.entries[static_cast<std::size_t>(i)]).object, i);
}

TEST(AnnotationsFile, ErrorsNameTheLineAndWhatToDo) {
  const std::string head = "schema = \"hapton.annotations/1\"\nobjects = [\"lid\"]\n";
  EXPECT_THAT(annotations_error("schema = \"hapton.annotations/2\""), HasSubstr("hapton.annotations/1"));
  EXPECT_THAT(annotations_error("objects = []"), HasSubstr("'schema'"));
  EXPECT_THAT(annotations_error(head + "storke = 1"), HasSubstr("line 3: unknown key 'storke'"));
  EXPECT_THAT(annotations_error(head + "stroke = 1"), HasSubstr("[[stroke]]"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0"), HasSubstr("'points_m'"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 1\npoints_m = [[0, 0, 0]]"), HasSubstr("line 4: an object is a number"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = -1\npoints_m = [[0, 0, 0]]"), HasSubstr("line 4"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = []"), HasSubstr("line 5"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = [[0, 0]]"), HasSubstr("three numbers"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = [[0, 0, nan]]"), HasSubstr("line 5: a coordinate"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = [[0, inf, 0]]"), HasSubstr("a coordinate"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = [[0, 1e7, 0]]"), HasSubstr("a coordinate"));
  EXPECT_THAT(annotations_error(head + "[[stroke]]\nobject = 0\npoints_m = [[0, \"1\", 0]]"), HasSubstr("a coordinate"));
  EXPECT_THAT(annotations_error(head + "[[measure]]\nobjects = [0]\npoints_m = [[0, 0, 0], [0, 0, 1]]"), HasSubstr("two objects"));
  EXPECT_THAT(annotations_error(head + "[[measure]]\nobjects = [0, 0]\npoints_m = [[0, 0, 0]]"), HasSubstr("two points"));
  EXPECT_THAT(annotations_error(head + "[[pose]]\nobject = 0\nposition_m = [0, 0, 0]\nrotation = [1, 1, 0, 0]"),
              HasSubstr("unit quaternion"));
  EXPECT_THAT(annotations_error(head + "[[pose]]\nobject = 0\nposition_m = [0, 0, nan]\nrotation = [1, 0, 0, 0]"), HasSubstr("position_m"));
  EXPECT_THAT(annotations_error("a = ["), HasSubstr("line 1"));
  for (const char* bad : {"schema = 1", "schema", "\xFF\xFE", ""}) EXPECT_THAT(annotations_error(bad), Not(HasSubstr("\n")));
}

TEST(AnnotationsFile, MorePointsThanTheLimitAreRejected) {
  Annotations many;
  many.objects = kAnnotatedNames;
  many.entries = {Stroke{0, std::vector<Vec3>(kMaxAnnotationPoints, Vec3::Zero())}};
  EXPECT_TRUE(parse_annotations(write_annotations(many, kAnnotatedHash), kAnnotatedNames, kAnnotatedHash));
  many.entries.emplace_back(Stroke{0, {Vec3::Zero()}});
  EXPECT_THAT(annotations_error(write_annotations(many, kAnnotatedHash)), HasSubstr("more than 100000 points"));
}

TEST(AnnotationsFile, ReadingNamesTheFile) {
  ScratchFolder scratch;
  const auto missing = read_annotations(scratch.path() / "none.toml", kAnnotatedNames, kAnnotatedHash);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().what, HasSubstr("none.toml"));
  const auto bad = read_annotations(scratch.write("bad.toml", "schema = 3\n"), kAnnotatedNames, kAnnotatedHash);
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().what, HasSubstr("bad.toml: line 1"));
}

// Whichever bytes of a file change, the reader accepts it or rejects it with an error of one line.
TEST(AnnotationsFile, MutatedFilesAreReadOrRejected) {
  constexpr std::uint64_t kSeed = 11;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const std::string original = write_annotations(make_annotations(), kAnnotatedHash);
  const std::string_view words[] = {"[", "]", "nan", "inf", "-1", "99999999999999999999", "\"", "[[stroke]]", "\n", "1e400", "object"};
  int read_count = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = original;
    for (std::size_t changes = 1 + random() % 4; changes > 0 && !text.empty(); --changes) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, 1 + random() % 40);
          break;
        case 2:
          text.insert(at, words[random() % std::size(words)]);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 60));
      }
    }
    const auto read = parse_annotations(text, kAnnotatedNames, kAnnotatedHash);
    if (!read) {
      EXPECT_THAT(read.error().what, Not(HasSubstr("\n")));
      continue;
    }
    ++read_count;
    const std::string written = write_annotations(read->annotations, kAnnotatedHash);
    const auto again = parse_annotations(written, kAnnotatedNames, kAnnotatedHash);
    ASSERT_TRUE(again) << again.error().what << "\n" << text;
  }
  EXPECT_GT(read_count, 0);
}

TEST(AnnotationsExport, ObjHasPolylinesWhereTheObjectsAre) {
  Pose X = Pose::Identity();
  X.translation() = Vec3(0, 0, 1);
  const std::string text = write_annotations_obj(make_annotations(), {Pose::Identity(), X}, kAnnotatedNames.size());
  EXPECT_THAT(text, HasSubstr("g stroke_1_box\nv 0.1 -0.2 1.3333333333333333\n"));
  EXPECT_THAT(text, HasSubstr("l 1 2 3\n"));
  EXPECT_THAT(text, HasSubstr("g measure_1\nv 0.25 0 1\n"));
  EXPECT_THAT(text, HasSubstr("l 4 5\n"));
  EXPECT_THAT(text, HasSubstr("p 6\n"));
}

TEST(AnnotationsExport, WhatIsOfAnotherSceneIsLeftOut) {
  const std::string obj = write_annotations_obj(make_annotations(), {}, 1);
  EXPECT_THAT(obj, Not(HasSubstr("\nv ")));
  EXPECT_THAT(write_annotations_vtp(make_annotations(), {}, 1), HasSubstr("NumberOfPoints=\"0\" NumberOfVerts=\"0\" NumberOfLines=\"0\""));
}

TEST(AnnotationsExport, VtpCountsItsCells) {
  const std::string text = write_annotations_vtp(make_annotations(), {}, kAnnotatedNames.size());
  EXPECT_THAT(text, HasSubstr("NumberOfPoints=\"6\" NumberOfVerts=\"1\" NumberOfLines=\"2\""));
}

// Carves have numbers of single precision: forces and pictures are computed with exactly these.
TEST(AnnotationsFile, CarvesAreReadBackToTheLastBit) {
  std::mt19937_64 random(11);
  Annotations annotations = make_annotations();
  for (std::int32_t press = 0; press < 40; ++press) {
    CarvedPress carved{.object = press % 3, .radius_m = rounded_to_float(0.001 + 1e-4 * press), .carves = {}};
    for (int n = 0; n < 50; ++n) {
      const auto number = [&] {
        const double size = std::exp2(-static_cast<double>(random() % 40));
        return size * (static_cast<double>(random() % 2'000'001) / 1e6 - 1.0);
      };
      Carve carve{.from_m = Vec3(number(), number(), number()), .radius_m = carved.radius_m};
      carve.to_m = n % 4 == 0 ? carve.from_m : Vec3(number(), number(), 0.0);
      carved.carves.push_back(rounded(carve));
    }
    annotations.carved.push_back(carved);
  }
  const std::string text = write_annotations(annotations, kAnnotatedHash);
  const auto read = parse_annotations(text, kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_TRUE(read->annotations.carved == annotations.carved);
  EXPECT_EQ(read->left_out, 0U);
  EXPECT_EQ(write_annotations(read->annotations, kAnnotatedHash), text);
}

// Undo removes the newest item, be it a carve, a stroke or a measure: the file must keep the order of all of them.
TEST(AnnotationsFile, TheOrderInWhichThingsWereMadeIsKept) {
  Annotations annotations;
  annotations.objects = kAnnotatedNames;
  const auto press = [](double x) {
    return CarvedPress{.object = 0, .radius_m = 0.5, .carves = {{.from_m = Vec3(x, 0, 0), .radius_m = 0.5}}};
  };
  annotations.carved = {press(1), press(2), press(3)};
  annotations.entries = {Measure{}, Stroke{0, {{1, 0, 0}}}, Measure{}, Stroke{0, {{2, 0, 0}}}};
  for (Annotation& entry : annotations.entries) {
    if (auto* measure = std::get_if<Measure>(&entry)) measure->ends[0].object = measure->ends[1].object = 1;
  }
  annotations.carved_before = {0, 2, 2, 3};
  const std::string text = write_annotations(annotations, kAnnotatedHash);
  const auto read = parse_annotations(text, kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_THAT(read->annotations.carved_before, ElementsAre(0, 2, 2, 3));
  ASSERT_EQ(read->annotations.entries.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(read->annotations.entries[i].index(), annotations.entries[i].index()) << i;
  EXPECT_TRUE(read->annotations.carved == annotations.carved);
  EXPECT_EQ(write_annotations(read->annotations, kAnnotatedHash), text);
}

TEST(AnnotationsFile, CarvesOfAnotherSceneStay) {
  Annotations annotations;
  annotations.objects = {"clay", "lid"};
  annotations.carved = {{.object = 0, .radius_m = 0.5, .carves = {{.radius_m = 0.5}}},
                        {.object = 1, .radius_m = 0.25, .carves = {{.radius_m = 0.25}}}};
  const auto read = parse_annotations(write_annotations(annotations, kAnnotatedHash), kAnnotatedNames, kAnnotatedHash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->left_out, 1U);
  ASSERT_EQ(read->annotations.carved.size(), 2U);
  EXPECT_EQ(read->annotations.carved[0].object, 3) << "after those of the scene";
  EXPECT_EQ(read->annotations.carved[1].object, 0);
}

TEST(AnnotationsFile, RejectsWhatIsNoCarve) {
  const std::string head = "schema = \"hapton.annotations/1\"\nscene_hash = \"0\"\nobjects = [\"lid\"]\n";
  const auto error = [&](const std::string& keys) { return annotations_error(head + "[[carve]]\n" + keys); };
  EXPECT_EQ(error("object = 0\nradius_m = 0.01\ncapsules_m = [[0, 0, 0, 1, 1, 1]]\n"), "it was read");
  EXPECT_THAT(error("object = 0\nradius_m = 0.01\n"), HasSubstr("capsules_m"));
  EXPECT_THAT(error("object = 0\nradius_m = 0.01\ncapsules_m = []\n"), HasSubstr("line 7: 'capsules_m' must be a list of capsules"));
  EXPECT_THAT(error("object = 0\nradius_m = 0.01\ncapsules_m = [[0, 0, 0]]\n"), HasSubstr("six numbers"));
  EXPECT_THAT(error("object = 0\nradius_m = 0.01\ncapsules_m = [[0, 0, 0, 0, 0, nan]]\n"), HasSubstr("line 7"));
  EXPECT_THAT(error("object = 0\nradius_m = 0.01\ncapsules_m = [[0, 0, 0, 0, 0, 1001]]\n"), HasSubstr("at most 1000 m apart"));
  EXPECT_THAT(error("object = 1\nradius_m = 0.01\ncapsules_m = [[0, 0, 0, 0, 0, 1]]\n"), HasSubstr("from 0 to 0"));
  for (const char* radius : {"0.0", "-1.0", "nan", "2000.0"}) {
    EXPECT_THAT(error(std::string("object = 0\nradius_m = ") + radius + "\ncapsules_m = [[0, 0, 0, 0, 0, 1]]\n"), HasSubstr("radius_m"))
        << radius;
  }
}

TEST(Carved, IsGroupedByPressWithoutWhatIsUndone) {
  CarveList list;
  for (std::uint32_t serial = 1; serial <= 7; ++serial) {
    list.add({.object = serial == 3 ? 1 : 0, .serial = serial, .carve = {.radius_m = 0.25}, .begins = serial == 1 || serial == 5});
  }
  list.add({.serial = 8, .undone = {5, 5}});
  const std::vector<CarvedPress> carved = group_carves(list);
  ASSERT_EQ(carved.size(), 4U) << "of a press, those of each object in a row";
  EXPECT_EQ(carved[0].carves.size(), 2U);
  EXPECT_EQ(carved[1].object, 1);
  EXPECT_EQ(carved[3].carves.size(), 2U) << "a press begins though its first carve is undone";
  EXPECT_EQ(count_carves(carved), 6U);
}

}  // namespace
}  // namespace hapton
