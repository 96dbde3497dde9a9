#include "core/sculpt/carve_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

MadeCarve make_entry(std::uint32_t serial, bool begins = false, int object = 0) {
  return {.object = object, .serial = serial, .carve = {.radius_m = 0.001 * serial}, .begins = begins};
}

MadeCarve make_undo(std::uint32_t serial, std::uint32_t first, std::uint32_t last) { return {.serial = serial, .undone = {first, last}}; }

TEST(CarveList, APressIsWhatWasCarvedUpToTheNextOne) {
  CarveList list;
  for (std::uint32_t serial = 1; serial <= 9; ++serial)
    EXPECT_TRUE(list.add(make_entry(serial, serial == 1 || serial == 4 || serial == 8)));
  EXPECT_EQ(list.find_press(2), (CarveRange{1, 3}));
  EXPECT_EQ(list.find_press(4), (CarveRange{4, 7}));
  EXPECT_EQ(list.find_press(9), (CarveRange{8, 9}));
  EXPECT_TRUE(list.find_press(10).is_empty());
  EXPECT_TRUE(list.find_press(0).is_empty());
  EXPECT_TRUE(list.add(make_undo(10, 8, 9)));
  EXPECT_EQ(list.newest(), 10U);
  EXPECT_EQ(list.newest_active(), 7U);
  EXPECT_EQ(list.count_active(), 7U);
  EXPECT_TRUE(list.find_press(10).is_empty()) << "an undo is not a carve";
  // The press goes on after the undo.
  EXPECT_TRUE(list.add(make_entry(11)));
  EXPECT_EQ(list.newest_active(), 11U);
  EXPECT_EQ(list.find_press(11), (CarveRange{8, 11}));
}

TEST(CarveList, InvalidEntriesAreRejected) {
  CarveList list;
  EXPECT_FALSE(list.add(make_entry(0)));
  EXPECT_FALSE(list.add(make_entry(CarveList::kMax + 1)));
  EXPECT_FALSE(list.add(make_undo(3, 1, 3))) << "it would undo itself";
  EXPECT_FALSE(list.add(make_undo(3, 2, 1)));
  EXPECT_TRUE(list.add(make_entry(2)));
  EXPECT_FALSE(list.add(make_entry(2))) << "the serial is in the list already";
  EXPECT_EQ(list.count_active(), 1U);
  EXPECT_TRUE(list.find_press(1).is_empty()) << "the list has no carve with this serial";
}

// Carves and undos in any order, some of them twice, give the same list as in order of their serials, each once.
TEST(CarveList, OrderAndRepetitionDoNotMatter) {
  std::mt19937_64 random(7);
  std::vector<MadeCarve> entries;
  for (std::uint32_t serial = 1; serial <= 300; ++serial) {
    const bool is_undo = serial > 20 && random() % 10 == 0;
    const auto last = static_cast<std::uint32_t>(1 + random() % (serial - 1 + (serial == 1 ? 1 : 0)));
    entries.push_back(is_undo ? make_undo(serial, last > 5 ? last - 5 : 1, last) : make_entry(serial, random() % 8 == 0));
  }
  CarveList in_order;
  for (const MadeCarve& entry : entries) EXPECT_TRUE(in_order.add(entry));
  ASSERT_LT(in_order.count_active(), 250U);
  ASSERT_GT(in_order.count_active(), 50U);
  for (int repetition = 0; repetition < 20; ++repetition) {
    std::vector<MadeCarve> shuffled = entries;
    shuffled.insert(shuffled.end(), entries.begin(), entries.begin() + 100);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    CarveList list;
    for (const MadeCarve& entry : shuffled) list.add(entry);
    EXPECT_EQ(list.newest(), in_order.newest());
    EXPECT_EQ(list.newest_active(), in_order.newest_active());
    EXPECT_EQ(list.count_active(), in_order.count_active());
    for (std::uint32_t serial = 1; serial <= 300; ++serial) ASSERT_EQ(list.is_active(serial), in_order.is_active(serial)) << serial;
  }
}

TEST(CarveList, KeepsCarvesAsMessagesRoundThem) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  CarveList list;
  std::vector<Carve> carves;
  for (std::uint32_t serial = 1; serial <= 100; ++serial) {
    const auto point = [&] { return Vec3(place(random), place(random), place(random)); };
    carves.push_back(rounded({point(), point(), 0.01 + 0.01 * place(random)}));
    list.add({.object = static_cast<int>(serial % 3), .serial = serial, .carve = carves.back()});
  }
  std::uint32_t visited_count = 0;
  list.for_each_active({11, 60}, [&](const MadeCarve& made) {
    EXPECT_EQ(made.serial, 11 + visited_count++);
    EXPECT_EQ(made.carve, carves[made.serial - 1]);
    EXPECT_EQ(made.object, static_cast<int>(made.serial % 3));
  });
  EXPECT_EQ(visited_count, 50U);
}

// The brute-force twin is an uncarved field, carved with all carves that are left.
TEST(RestoreUndone, IsTheFieldOfTheCarvesThatAreLeftToTheLastBit) {
  for (const auto& [mesh, voxel] : {std::pair(make_icosphere(0.03, 4), 0.0013), std::pair(make_box(Vec3(0.05, 0.03, 0.04)), 0.001)}) {
    const auto uncarved = CarvedField::make(mesh, voxel);
    ASSERT_TRUE(uncarved) << uncarved.error().what;
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-0.04, 0.04), length(-0.006, 0.006), radius(0.002, 0.008);
    CarveList list;
    CarvedField field = *uncarved;
    std::uint32_t undos_with_effect = 0;
    for (std::uint32_t serial = 1; serial <= 400; ++serial) {
      if (serial % 20 == 0) {
        // The range may include carves that are already undone, span several presses, and include carves of another object.
        const auto last = static_cast<std::uint32_t>(1 + random() % (serial - 1));
        const CarveRange undone{last > 7 ? last - 7 : 1, last};
        ASSERT_TRUE(list.add({.serial = serial, .undone = undone}));
        const CarvedFieldBox box = restore_undone(list, 1, undone, *uncarved, field);
        undos_with_effect += box.is_empty() ? 0 : 1;
        CarvedField twin = *uncarved;
        list.for_each_active({}, [&](const MadeCarve& made) {
          if (made.object == 1) twin.carve(made.carve);
        });
        ASSERT_TRUE(std::equal(field.values().begin(), field.values().end(), twin.values().begin())) << serial;
        continue;
      }
      const Vec3 from(place(random), place(random), place(random));
      MadeCarve made{.object = serial % 5 == 0 ? 0 : 1, .serial = serial, .carve = {from, from, radius(random)}, .begins = serial % 6 == 1};
      made.carve.to_m += Vec3(length(random), length(random), length(random));
      made.carve = rounded(made.carve);
      ASSERT_TRUE(list.add(made));
      if (made.object == 1) field.carve(made.carve);
    }
    EXPECT_GT(undos_with_effect, 15U);
  }
}

// If a node outside the box changed, a picture that recomputes only the box would show a crack.
TEST(RestoreUndone, ReturnsABoxAroundAllThatChanges) {
  const auto uncarved = CarvedField::make(make_icosphere(0.03, 4), 0.0013);
  ASSERT_TRUE(uncarved);
  CarveList list;
  CarvedField field = *uncarved;
  for (std::uint32_t serial = 1; serial <= 2; ++serial) {
    const Vec3 centre = serial == 1 ? Vec3(0.03, 0, 0) : Vec3(-0.02, 0.02, 0);
    list.add({.object = 0, .serial = serial, .carve = rounded({centre, centre, 0.005}), .begins = true});
    field.carve({centre, centre, 0.005});
  }
  const CarvedField before = field;
  list.add({.serial = 3, .undone = {1, 1}});
  const CarvedFieldBox box = restore_undone(list, 0, {1, 1}, *uncarved, field);
  std::size_t changed_nodes = 0;
  for (int z = 0; z < field.nodes()[2]; ++z) {
    for (int y = 0; y < field.nodes()[1]; ++y) {
      for (int x = 0; x < field.nodes()[0]; ++x) {
        const std::size_t node = field.grid().index(x, y, z);
        if (field.values()[node] == before.values()[node]) continue;
        ++changed_nodes;
        ASSERT_TRUE(x >= box.low[0] && x < box.high[0] && y >= box.low[1] && y < box.high[1] && z >= box.low[2] && z < box.high[2]);
      }
    }
  }
  EXPECT_GT(changed_nodes, 100U);
  EXPECT_LT(static_cast<std::size_t>((box.high[0] - box.low[0]) * (box.high[1] - box.low[1]) * (box.high[2] - box.low[2])),
            field.values().size() / 4)
      << "a small part of the grid";
  EXPECT_TRUE(restore_undone(list, 5, {1, 1}, *uncarved, field).is_empty()) << "the carve belongs to another object";
}

}  // namespace
}  // namespace hapton
