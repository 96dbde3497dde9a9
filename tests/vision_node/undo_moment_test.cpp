#include "vision_node/undo_moment.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

Carve carve_at(double x) { return rounded(Carve{.from_m = Vec3(x, 0, 0), .to_m = Vec3(x, 0.1, 0), .radius_m = 0.01}); }

CarvedPress press_at(double x) { return {.object = 0, .radius_m = 0.01, .carves = {carve_at(x), carve_at(x + 0.5)}}; }

// A list of presses, at these places, of two carves each.
CarveList list_of(std::initializer_list<double> places) {
  CarveList list;
  std::uint32_t serial = 0;
  for (const double x : places) {
    list.add({.object = 0, .serial = ++serial, .carve = carve_at(x), .begins = true});
    list.add({.object = 0, .serial = ++serial, .carve = carve_at(x + 0.5)});
  }
  return list;
}

TEST(CarveMoments, OfTheSameListAreItsSerials) {
  const CarveList list = list_of({1, 2});
  EXPECT_EQ(CarveMoments(list, 7, {}).find_serial({.source = 7, .serial = 3}), 3U);
  EXPECT_EQ(CarveMoments(list, 8, {}).find_serial({.source = 7, .serial = 3}), 0U) << "of another list";
}

TEST(CarveMoments, OfAnotherListAreFoundByThePressesOfTheFile) {
  const std::vector<CarvedPress> saved = {press_at(1), press_at(2), press_at(1)};
  const CarveList list = list_of({1, 2, 1, 3});
  const CarveMoments moments(list, 7, saved);
  EXPECT_EQ(moments.find_serial({.saved_presses = 0}), 0U);
  EXPECT_EQ(moments.find_serial({.saved_presses = 1}), 2U) << "the whole press";
  EXPECT_EQ(moments.find_serial({.saved_presses = 2}), 4U);
  EXPECT_EQ(moments.find_serial({.saved_presses = 3}), 6U) << "the same place once more";
  EXPECT_EQ(moments.find_serial({.saved_presses = 9}), 6U);
  EXPECT_EQ(moments.find_serial({.saved_presses = 1, .source = 7, .serial = 5}), 5U);
}

TEST(CarveMoments, PressesThatAreNotInTheListDoNotMatter) {
  const CarveMoments moments(list_of({2}), 7, {press_at(1), press_at(2)});
  EXPECT_EQ(moments.find_serial({.saved_presses = 1}), 0U);
  EXPECT_EQ(moments.find_serial({.saved_presses = 2}), 2U);
  // The first carve of a press changed nothing, and is not in the list: only its second carve is.
  CarveList list;
  list.add({.object = 0, .serial = 1, .carve = carve_at(1.5), .begins = true});
  EXPECT_EQ(CarveMoments(list, 7, {press_at(1)}).find_serial({.saved_presses = 1}), 1U);
}

}  // namespace
}  // namespace hapton
