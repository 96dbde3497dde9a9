#include "recording/cycle_table.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/recording/made_entries.h"

namespace hapton {
namespace {

struct Joined {
  std::vector<CycleRow> rows;
  CycleTable table{kCyclesStartNs, [this](const CycleRow& row) { rows.push_back(row); }};

  void force(std::uint64_t sample, std::int64_t time_ns) {
    const auto [entry, datagram] = arrival_of(force_of(sample), time_ns);
    table.add(entry, &datagram);
  }
};

TEST(CycleTable, AForceStandsBesideItsSampleWheneverItCame) {
  Joined joined;
  joined.force(1, sample_ns(1) + 100'000);  // before the cycle is recorded, as on a fast network
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.table.add(cycle_of(3), nullptr);
  joined.force(3, sample_ns(3) + 300'000);
  joined.force(2, sample_ns(3) + 400'000);  // overtaken by the force for sample 3
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const CycleRow& row = joined.rows[i];
    EXPECT_EQ(row.sample, i + 1);
    EXPECT_EQ(row.wanted_n.z(), static_cast<double>(i + 1));
    EXPECT_DOUBLE_EQ(row.p_WP.z(), 0.201);
    EXPECT_TRUE(row.is_contact);
    EXPECT_EQ(row.object, 1);
    EXPECT_FALSE(row.is_local);
    EXPECT_EQ(row.buttons, 5U);
  }
  EXPECT_NEAR(joined.rows[0].sample_t_s, 1e-3, 1e-12);
  EXPECT_NEAR(joined.rows[1].v_WD.x(), 0.1, 1e-9);
  EXPECT_NEAR(joined.rows[1].round_trip_s, 1.4e-3, 1e-12);
  EXPECT_EQ(joined.rows[2].missed, 2U);
}

TEST(CycleTable, ARowWhoseForceNeverComesIsThereWithoutOne) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.force(2, sample_ns(2) + 300'000);
  EXPECT_TRUE(joined.rows.empty()) << "in the order of the samples";
  joined.table.add(cycle_of(6000), nullptr);
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(joined.rows[0].wanted_n.x()));
  EXPECT_TRUE(std::isnan(joined.rows[0].round_trip_s));
  EXPECT_FALSE(joined.rows[0].is_contact);
  const auto contact = std::ranges::find(cycle_columns(), std::string_view("contact"), &CycleColumn::name);
  ASSERT_NE(contact, cycle_columns().end());
  EXPECT_TRUE(std::isnan(contact->of(joined.rows[0]))) << "not known";
  EXPECT_FALSE(std::isnan(contact->of(joined.rows[1])));
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

TEST(CycleTable, LocalForcesEventsAndOlderRecordings) {
  Joined joined;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  joined.table.add(fault, nullptr);
  fault.fault = SessionFault::speed;
  joined.table.add(fault, nullptr);
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 1e-3, 0.0), 6};
  joined.table.add(local, nullptr);
  SessionEntry old = cycle_of(2);
  old.cycle.device.reset();
  joined.table.add(old, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "clamped speed");
  EXPECT_TRUE(joined.rows[0].is_local);
  EXPECT_EQ(joined.rows[0].object, 6);
  EXPECT_TRUE(joined.rows[0].is_contact);
  EXPECT_EQ(joined.rows[0].wanted_n.y(), 2.0);
  EXPECT_DOUBLE_EQ(joined.rows[0].p_WP.y(), 1e-3);
  EXPECT_EQ(joined.table.without_sample(), 1U);
}

TEST(CycleTable, AGapIsNamedAndCounted) {
  Joined joined;
  for (const std::uint64_t sample : {40U, 41U, 157U, 158U, 158U, 160U}) joined.table.add(cycle_of(sample), nullptr);
  joined.table.finish();
  std::vector<std::uint64_t> lost;
  for (const CycleRow& row : joined.rows) lost.push_back(row.lost);
  EXPECT_EQ(lost, (std::vector<std::uint64_t>{0, 0, 115, 0, 0, 1})) << "what was before a flight record is not a gap";
  EXPECT_EQ(joined.table.lost(), 116U);
  EXPECT_EQ(joined.table.gaps(), 2U);
}

TEST(CycleTable, AMarkerStandsAtItsSample) {
  Joined joined;
  joined.table.add(marker_of(1, "begin"), nullptr);  // within the cycle, as usual
  joined.table.add(cycle_of(1), nullptr);
  joined.force(1, sample_ns(1) + 250'000);
  joined.table.add(marker_of(1, "after its force"), nullptr);
  joined.table.add(marker_of(2, "of a lost row"), nullptr);
  joined.table.add(cycle_of(4), nullptr);
  joined.table.add(marker_of(5, "at the end"), nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_EQ(joined.rows[0].markers, (std::vector<std::string>{"begin", "after its force"}));
  EXPECT_EQ(joined.rows[1].markers, (std::vector<std::string>{"of a lost row", "at the end"}));
  Joined empty;
  empty.table.add(marker_of(5, "without a row"), nullptr);
  empty.table.finish();
  EXPECT_TRUE(empty.rows.empty());
}

// As when `--overrun stop` ends a session: the fault is the last entry.
TEST(CycleTable, AFaultBehindTheLastCycleIsNotLost) {
  Joined joined;
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{};
  joined.table.add(local, nullptr);
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::overrun;
  joined.table.add(fault, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "overrun");
}

TEST(CycleTable, WhatNoForceCameForIsNotKnown) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  const CycleRow& row = joined.rows[0];
  EXPECT_TRUE(row.p_WP.array().isNaN().all());
  EXPECT_TRUE(row.q_WP.coeffs().array().isNaN().all());
  EXPECT_TRUE(row.wanted_nm.array().isNaN().all());
  EXPECT_EQ(row.object, -1);
  EXPECT_FALSE(row.view_revision);
  EXPECT_EQ(row.written_n.z(), 0.5) << "what the motors got is known";
  EXPECT_DOUBLE_EQ(row.late_s, 3e-6);
}

// If a sample has the time of the sample before it, or an earlier time, or is the first one, the difference gives no velocity.
TEST(CycleTable, AVelocityNeedsTimeBetweenTwoSamples) {
  Joined joined;
  joined.table.add(cycle_of(4), nullptr);
  SessionEntry again = cycle_of(5);
  again.cycle.device->time_ns = sample_ns(4);
  joined.table.add(again, nullptr);
  SessionEntry earlier = cycle_of(6);
  earlier.cycle.device->time_ns = sample_ns(3);
  joined.table.add(earlier, nullptr);
  joined.table.add(cycle_of(7), nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(joined.rows[i].v_WD, Vec3(0.0, 0.0, 0.0)) << i;
  EXPECT_NEAR(joined.rows[3].v_WD.x(), 1e-4 / 4e-3, 1e-9);
}

TEST(CycleTable, TheFirstForceOfASampleIsTheOneThatActed) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(3), nullptr);
  joined.force(2, sample_ns(3));  // for a sample that the recording lacks
  ForceCommand second = force_of(3);
  joined.force(3, sample_ns(3) + 250'000);
  second.force_n = Vec3(9.0, 9.0, 9.0);
  const auto [entry, datagram] = arrival_of(second, sample_ns(3) + 400'000);
  joined.table.add(entry, &datagram);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(joined.rows[0].wanted_n.z()));
  EXPECT_EQ(joined.rows[1].wanted_n, Vec3(0.0, 0.0, 3.0));
  EXPECT_NEAR(joined.rows[1].round_trip_s, 2.5e-4, 1e-12);
}

// Only a force that the hub received can act; a force that it sent is not a reply to it.
TEST(CycleTable, AForceThatWasSentIsNoReply) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  auto [entry, datagram] = arrival_of(force_of(1), sample_ns(1) + 250'000);
  entry.kind = SessionEntry::Kind::sent;
  joined.table.add(entry, &datagram);
  joined.table.finish();
  EXPECT_TRUE(std::isnan(joined.rows.at(0).wanted_n.z()));
}

// At most 64 forces wait for their cycles; one more drops the oldest.
TEST(CycleTable, OnlySoManyForcesWaitForTheirCycles) {
  for (const std::uint64_t early : {64U, 65U}) {
    Joined joined;
    for (std::uint64_t sample = 1; sample <= early; ++sample) joined.force(sample, sample_ns(sample));
    for (std::uint64_t sample = 1; sample <= early; ++sample) joined.table.add(cycle_of(sample), nullptr);
    joined.table.finish();
    ASSERT_EQ(joined.rows.size(), early);
    EXPECT_EQ(std::isnan(joined.rows[0].wanted_n.z()), early == 65U);
    for (std::size_t i = 1; i < early; ++i) ASSERT_EQ(joined.rows[i].wanted_n.z(), static_cast<double>(i + 1));
  }
}

TEST(CycleTable, ForcesComputedBesideTheDevice) {
  Joined joined;
  for (const double force_n : {0.0, 0.3}) {
    SessionEntry local = cycle_of(force_n > 0.0 ? 2 : 1);
    local.cycle.device->q_WT = Quat(0.6, 0.8, 0.0, 0.0);
    local.cycle.local = CycleLocal{Vec3(0.0, force_n, 0.0), Vec3::Zero(), 2};
    joined.table.add(local, nullptr);
  }
  joined.force(2, sample_ns(2) + 100'000);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_FALSE(joined.rows[0].is_contact) << "no force";
  EXPECT_TRUE(joined.rows[1].is_contact);
  EXPECT_EQ(joined.rows[1].wanted_n.y(), 0.3) << "not that of the haptics node, which came as well";
  EXPECT_EQ(joined.rows[1].wanted_nm, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(joined.rows[1].q_WP.coeffs(), Quat(0.6, 0.8, 0.0, 0.0).coeffs());
}

// A row is given out when no force can come in time any more: after more than five seconds, not at exactly five seconds.
TEST(CycleTable, ARowWaitsForItsForceAsLongAsItMayCome) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  SessionEntry later = marker_of(2, "later");
  later.time_ns = cycle_of(1).time_ns + 5'000'000'000;
  joined.table.add(later, nullptr);
  EXPECT_TRUE(joined.rows.empty());
  later.time_ns += 1;
  joined.table.add(later, nullptr);
  EXPECT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.table.rows(), 1U);
  joined.table.finish();
  EXPECT_EQ(joined.table.rows(), 2U);
}

TEST(CycleTable, AFaultAfterTheLastCycleStandsBehindThoseOfTheCycle) {
  Joined joined;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  joined.table.add(fault, nullptr);
  joined.table.add(cycle_of(1), nullptr);
  fault.fault = SessionFault::overrun;
  joined.table.add(fault, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "clamped overrun");
}

TEST(CycleTable, TimesOfAHostileFileDoNoHarm) {
  Joined joined;
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns / 2;
    joined.table.add(entry, nullptr);
  }
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

// Every exported file has these columns.
TEST(CycleTable, EachColumnHasTheValueThatItsNameSays) {
  CycleRow row;
  row.sample_t_s = 0.25;
  row.sample = 2;
  row.p_WD = Vec3(3, 4, 5);
  row.q_WT = Quat(6, 7, 8, 9);
  row.v_WD = Vec3(10, 11, 12);
  row.buttons = 13;
  row.p_WP = Vec3(14, 15, 16);
  row.wanted_n = Vec3(17, 18, 19);
  row.written_n = Vec3(20, 21, 22);
  row.q_WP = Quat(23, 24, 25, 26);
  row.wanted_nm = Vec3(27, 28, 29);
  row.written_nm = Vec3(30, 31, 32);
  row.is_contact = true;
  row.object = 33;
  row.round_trip_s = 34;
  row.late_s = 35;
  row.missed = 36;
  row.lost = 37;
  row.view_revision = 1;
  row.scene_time_ns = 500'000'000;
  row.carve_serial = 38;
  const auto text_of_row = [&] {
    std::string text;
    for (const CycleColumn& column : cycle_columns()) text += fmt::format("{}={:g} ", column.name, column.of(row));
    return text;
  };
  EXPECT_EQ(text_of_row(),
            "t_s=0.25 sample=2 x_m=3 y_m=4 z_m=5 qw=6 qx=7 qy=8 qz=9 vx_m_per_s=10 vy_m_per_s=11 vz_m_per_s=12 buttons=13 proxy_x_m=14 "
            "proxy_y_m=15 proxy_z_m=16 wanted_x_n=17 wanted_y_n=18 wanted_z_n=19 written_x_n=20 written_y_n=21 written_z_n=22 proxy_qw=23 "
            "proxy_qx=24 proxy_qy=25 proxy_qz=26 wanted_tx_nm=27 wanted_ty_nm=28 wanted_tz_nm=29 written_tx_nm=30 written_ty_nm=31 "
            "written_tz_nm=32 contact=1 object=33 local=0 round_trip_s=34 late_s=35 missed=36 lost=37 scene_time_s=0.5 carve_serial=38 ");
  row.is_contact = false;
  row.is_local = true;
  row.object = -1;
  row.view_revision.reset();
  EXPECT_NE(text_of_row().find("contact=0 object=nan local=1 "), std::string::npos);
  EXPECT_NE(text_of_row().find("scene_time_s=nan carve_serial=nan "), std::string::npos);
}

TEST(CycleTable, ARowOfARigidToolHasItsTorquesAndHowItIsTurned) {
  Joined joined;
  SessionEntry cycle = cycle_of(1);
  cycle.cycle.device->q_WT = Quat(0.6, 0.8, 0.0, 0.0);
  cycle.cycle.written_nm = Vec3(0.25, 0.0, -0.125);
  joined.table.add(cycle, nullptr);
  ForceCommand force = force_of(1);
  force.torque_nm = Vec3(0.5, 0.0, -0.25);
  force.visual_turn = Vec3(0.0, 0.0, 0.3);
  const auto [entry, datagram] = arrival_of(force, sample_ns(1) + 250'000);
  joined.table.add(entry, &datagram);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  const CycleRow& row = joined.rows[0];
  EXPECT_EQ(row.wanted_nm, Vec3(0.5, 0.0, -0.25));
  EXPECT_EQ(row.written_nm, Vec3(0.25, 0.0, -0.125));
  const Quat expected = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())) * Quat(0.6, 0.8, 0.0, 0.0);
  EXPECT_LT((row.q_WP.coeffs() - expected.coeffs()).norm(), 1e-12) << "turned in W from how the stylus is held";
}

}  // namespace
}  // namespace hapton
