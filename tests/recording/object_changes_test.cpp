#include "recording/object_changes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "tests/recording/made_entries.h"

namespace hapton {
namespace {

// Adds a message of the haptics node at a time.
void receive(ObjectChanges& changes, const Message& message, double t_s, SessionEntry::Kind kind = SessionEntry::Kind::received,
             std::uint64_t sender = 4) {
  SessionEntry entry;
  entry.kind = kind;
  entry.time_ns = kCyclesStartNs + static_cast<std::int64_t>(1e9 * t_s);
  const Datagram datagram{{.sender = sender}, message};
  changes.add(entry, &datagram);
}

ObjectMove make_object_move(std::uint32_t source, std::uint32_t serial, std::int32_t object) {
  ObjectMove move{.source = source,
                  .serial = serial,
                  .object = object,
                  .start_ns = 500'000'000,
                  .end_ns = 1'500'000'000,
                  .to_p_m = Vec3(0.0, 0.0, 0.25)};
  std::strcpy(move.name.data(), "lid");
  return move;
}

Carves make_carves(std::uint32_t source, std::uint32_t newest, std::uint32_t first, std::uint32_t count) {
  Carves carves{.source = source, .newest = newest, .first = first, .count = count};
  for (std::uint32_t n = 0; n < count; ++n)
    carves.carves[n] = {.object = 1, .to_m = {0.5F, 0.0F, 0.0F}, .radius_m = static_cast<float>(first + n)};
  return carves;
}

template <class Row>
double value_of(std::span<const ChangeColumn<Row>> columns, std::string_view name, const Row& row) {
  for (const auto& column : columns) {
    if (column.name == name) return column.of(row);
  }
  ADD_FAILURE() << "no column " << name;
  return NAN;
}

TEST(ObjectChanges, EachSceneAndMethodIsThereOnceInItsOrder) {
  ObjectChanges changes(kCyclesStartNs);
  HapticsSetup setup{.scene_hash = 7};
  for (const double t_s : {0.5, 1.5, 2.5}) receive(changes, setup, t_s);  // the haptics node repeats it
  setup.scene_hash = 8;
  receive(changes, setup, 3.0);
  receive(changes, setup, 4.0, SessionEntry::Kind::sent);
  setup.scene_hash = 7;
  receive(changes, setup, 5.0);
  ASSERT_EQ(changes.setups().size(), 3U);
  EXPECT_NEAR(changes.setups()[0].t_s, 0.5, 1e-9);
  EXPECT_EQ(changes.setups()[1].setup.scene_hash, 8U);
  EXPECT_NEAR(changes.setups()[2].t_s, 5.0, 1e-9);
}

TEST(ObjectChanges, EachMoveIsThereOnceWithItsName) {
  ObjectChanges changes(kCyclesStartNs);
  receive(changes, make_object_move(5, 0, 2), 0.5);
  receive(changes, make_object_move(5, 1, 2), 1.0);
  receive(changes, make_object_move(5, 1, 2), 1.1);
  receive(changes, make_object_move(5, 1, 2), 1.1, SessionEntry::Kind::sent);
  receive(changes, make_object_move(5, 2, 0), 1.2);
  receive(changes, make_object_move(5, 3, 2), 1.3);
  receive(changes, make_object_move(6, 1, 2), 1.4);
  changes.finish();
  ASSERT_EQ(changes.moves().size(), 4U) << "neither the pose at rest nor repetitions nor the hub's copies";
  EXPECT_STREQ(changes.moves()[0].move.name.data(), "lid");
  EXPECT_EQ(changes.moves()[2].move.serial, 3U);
  EXPECT_EQ(changes.moves()[3].process, 1U);
  const RecordedMove& first = changes.moves()[0];
  EXPECT_NEAR(value_of(move_columns(), "t_s", first), 1.0, 1e-9);
  EXPECT_EQ(value_of(move_columns(), "object", first), 2.0);
  EXPECT_EQ(value_of(move_columns(), "start_scene_time_s", first), 0.5);
  EXPECT_EQ(value_of(move_columns(), "end_scene_time_s", first), 1.5);
  EXPECT_EQ(value_of(move_columns(), "to_z_m", first), 0.25);
  EXPECT_EQ(value_of(move_columns(), "to_qw", first), 1.0);
}

TEST(ObjectChanges, CarvesAreInTheOrderOfTheirSerials) {
  ObjectChanges changes(kCyclesStartNs);
  receive(changes, Carves{.source = 7, .newest = 3}, 0.1);
  receive(changes, make_carves(7, 5, 4, 2), 0.2);  // made during the recording
  receive(changes, make_carves(7, 5, 1, 4), 0.3);  // sent again on request
  receive(changes, make_carves(9, 1, 1, 1), 0.4);
  changes.finish();
  ASSERT_EQ(changes.carves().size(), 6U);
  for (std::uint32_t n = 0; n < 5; ++n) {
    const RecordedCarve& one = changes.carves()[n];
    EXPECT_EQ(one.serial, n + 1);
    EXPECT_EQ(one.process, 0U);
    EXPECT_EQ(one.carve.radius_m, static_cast<float>(n + 1));
    EXPECT_EQ(std::isnan(one.t_s), n < 3) << "made before the recording: " << n;
  }
  EXPECT_NEAR(changes.carves()[4].t_s, 0.2, 1e-9);
  EXPECT_EQ(changes.carves()[5].process, 1U);
  EXPECT_NEAR(changes.carves()[5].t_s, 0.4, 1e-9);
  EXPECT_EQ(value_of(carve_columns(), "to_x_m", changes.carves()[5]), 0.5);
  EXPECT_EQ(value_of(carve_columns(), "radius_m", changes.carves()[5]), 1.0);
}

// The first message that comes may repeat carves from the first one on, because a vision node requested them.
TEST(ObjectChanges, TheFirstForceTellsWhichCarvesAreEarlier) {
  for (const bool is_force_first : {true, false}) {
    ObjectChanges changes(kCyclesStartNs);
    if (is_force_first) receive(changes, ForceCommand{.carve_serial = 2}, 0.1);
    receive(changes, make_carves(7, 3, 1, 3), 0.2);
    receive(changes, ForceCommand{.carve_serial = 4}, 0.3);
    receive(changes, make_carves(7, 5, 4, 2), 0.4);
    changes.finish();
    ASSERT_EQ(changes.carves().size(), 5U);
    for (const RecordedCarve& one : changes.carves()) {
      EXPECT_EQ(std::isnan(one.t_s), one.serial <= (is_force_first ? 2U : 3U)) << is_force_first << ", " << one.serial;
    }
  }
}

// Whoever joins the tables by the number of the process finds what one process did.
TEST(ObjectChanges, AProcessHasOneNumberInAllTables) {
  ObjectChanges changes(kCyclesStartNs);
  receive(changes, make_object_move(7, 1, 2), 0.1);
  receive(changes, ShapeStart{.source = 8, .serial = 1, .object = 1, .total = 2}, 0.2);
  receive(changes, make_carves(9, 2, 2, 1), 0.3);
  receive(changes, make_object_move(9, 1, 2), 0.4);
  receive(changes, CarveStatus{.source = 11}, 0.5);
  receive(changes, make_carves(9, 2, 1, 1), 0.6);
  changes.finish();
  ASSERT_EQ(changes.moves().size(), 2U);
  EXPECT_EQ(changes.moves()[0].process, 0U);
  EXPECT_EQ(changes.moves()[1].process, 2U);
  ASSERT_EQ(changes.carves().size(), 2U);
  EXPECT_EQ(changes.carves()[0].process, 2U);
  EXPECT_NEAR(changes.carves()[0].t_s, 0.6, 1e-9) << "its process began within the recording";
}

// Memory is bounded: a serial far above those of any session is ignored.
TEST(ObjectChanges, SerialsOfAHostileFileDoNoHarm) {
  ObjectChanges changes(kCyclesStartNs);
  receive(changes, make_carves(7, ~0U, ~0U - 3, 4), 0.1);
  changes.finish();
  EXPECT_TRUE(changes.carves().empty());
}

template <class Row>
std::string row_text(std::span<const ChangeColumn<Row>> columns, const Row& row) {
  std::string text;
  for (const auto& column : columns) text += fmt::format("{}={:g} ", column.name, column.of(row));
  return text;
}

// Every exported file has these columns.
TEST(ObjectChanges, EachColumnHasTheValueThatItsNameSays) {
  RecordedMove move;
  move.t_s = 0.25;
  move.process = 2;
  move.move = {.source = 9, .serial = 3, .object = 4, .start_ns = 500'000'000, .end_ns = 1'500'000'000};
  move.move.from_p_m = Vec3(5, 6, 7);
  move.move.from_q = Quat(8, 9, 10, 11);
  move.move.to_p_m = Vec3(12, 13, 14);
  move.move.to_q = Quat(15, 16, 17, 18);
  EXPECT_EQ(row_text(move_columns(), move),
            "t_s=0.25 process=2 serial=3 object=4 start_scene_time_s=0.5 end_scene_time_s=1.5 from_x_m=5 from_y_m=6 from_z_m=7 from_qw=8 "
            "from_qx=9 from_qy=10 from_qz=11 to_x_m=12 to_y_m=13 to_z_m=14 to_qw=15 to_qx=16 to_qy=17 to_qz=18 ");
  RecordedCarve carve;
  carve.t_s = 0.25;
  carve.process = 2;
  carve.serial = 3;
  carve.carve = {.object = 4, .from_m = {5, 6, 7}, .to_m = {8, 9, 10}, .radius_m = 11, .begins = true};
  carve.carve.undone_first = 12;
  carve.carve.undone_last = 13;
  EXPECT_EQ(row_text(carve_columns(), carve),
            "t_s=0.25 process=2 serial=3 object=4 from_x_m=5 from_y_m=6 from_z_m=7 to_x_m=8 to_y_m=9 to_z_m=10 radius_m=11 begins=1 "
            "undone_first=12 undone_last=13 ");
}

// Another method, scene, way to load the scene, build or haptics node is another set-up: forces from then on are computed with it.
TEST(ObjectChanges, WhateverChangesInASetupMakesItAnother) {
  ObjectChanges changes(kCyclesStartNs);
  HapticsSetup setup;
  receive(changes, setup, 0.5);
  std::strcpy(setup.method.data(), "name=smooth");
  receive(changes, setup, 1.0);
  std::strcpy(setup.scene.data(), "other.toml");
  receive(changes, setup, 1.5);
  setup.scene_loading = 3;
  receive(changes, setup, 2.0);
  std::strcpy(setup.build.data(), "0.9");
  receive(changes, setup, 2.5);
  receive(changes, setup, 3.0);
  ASSERT_EQ(changes.setups().size(), 5U);
  for (std::size_t n = 0; n < 5; ++n) EXPECT_NEAR(changes.setups()[n].t_s, 0.5 + 0.5 * static_cast<double>(n), 1e-9);
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::received;
  entry.time_ns = kCyclesStartNs + 3'500'000'000;
  const Datagram from_another_node{{.sender = 9}, setup};
  changes.add(entry, &from_another_node);
  ASSERT_EQ(changes.setups().size(), 6U);
  EXPECT_EQ(changes.setups().back().sender, 9U);
}

// The hub began to record while the stylus carved: the first message already has carves, and the hub requests the earlier ones.
TEST(ObjectChanges, CarvesBeforeTheFirstReceivedOneAreFromBeforeTheRecording) {
  ObjectChanges changes(kCyclesStartNs);
  receive(changes, ForceCommand{.carve_serial = 3}, 0.1);
  receive(changes, make_carves(7, 6, 4, 2), 0.2);
  receive(changes, make_carves(7, 6, 6, 1), 0.25);
  receive(changes, make_carves(7, 6, 1, 3), 0.3);
  changes.finish();
  ASSERT_EQ(changes.carves().size(), 6U);
  for (std::uint32_t n = 0; n < 3; ++n) EXPECT_TRUE(std::isnan(changes.carves()[n].t_s)) << n;
  for (std::uint32_t n = 3; n < 6; ++n) EXPECT_NEAR(changes.carves()[n].t_s, n < 5 ? 0.2 : 0.25, 1e-9) << n;
}

// A field node that cannot carve, or a haptics node that has ended, states another serial than the process that carves.
TEST(ObjectChanges, ForcesOfAnotherProcessDoNotDecideWhichCarvesAreEarlier) {
  for (const std::uint32_t serial_of_other : {0U, 500U}) {
    ObjectChanges with_force(kCyclesStartNs);
    constexpr auto kReceived = SessionEntry::Kind::received;
    receive(with_force, ForceCommand{.carve_serial = serial_of_other}, 0.1, kReceived, 4);
    receive(with_force, ForceCommand{.carve_serial = 1}, 0.15, kReceived, 5);
    receive(with_force, ForceCommand{.carve_serial = serial_of_other}, 0.16, kReceived, 4);
    receive(with_force, ForceCommand{.carve_serial = 2}, 0.17, kReceived, 5);
    receive(with_force, make_carves(7, 3, 1, 3), 0.2, kReceived, 5);
    with_force.finish();
    ASSERT_EQ(with_force.carves().size(), 3U);
    EXPECT_TRUE(std::isnan(with_force.carves()[0].t_s));
    EXPECT_NEAR(with_force.carves()[1].t_s, 0.2, 1e-9);

    ObjectChanges announced(kCyclesStartNs);
    receive(announced, ForceCommand{.carve_serial = serial_of_other}, 0.1, kReceived, 4);
    receive(announced, make_carves(7, 3, 0, 0), 0.2, kReceived, 5);
    receive(announced, ForceCommand{.carve_serial = 0}, 0.25, kReceived, 5);
    receive(announced, make_carves(7, 4, 1, 4), 0.3, kReceived, 5);
    announced.finish();
    ASSERT_EQ(announced.carves().size(), 4U);
    EXPECT_TRUE(std::isnan(announced.carves()[2].t_s));
    EXPECT_NEAR(announced.carves()[3].t_s, 0.3, 1e-9);
  }
}

}  // namespace
}  // namespace hapton
