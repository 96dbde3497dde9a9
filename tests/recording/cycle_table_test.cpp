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

// A table of cycles, and the rows that it has passed on.
struct TableWithRows {
  std::vector<CycleRow> rows;
  CycleTable table{kCyclesStartNs, [this](const CycleRow& row) { rows.push_back(row); }};

  void add_force(std::uint64_t sample, std::int64_t time_ns) {
    const auto [entry, datagram] = arrival_of(force_of(sample), time_ns);
    table.add(entry, &datagram);
  }
};

TEST(CycleTable, AForceIsInTheRowOfItsSampleWheneverItArrives) {
  TableWithRows cycles;
  cycles.add_force(1, sample_ns(1) + 100'000);  // before the cycle is recorded, as on a fast network
  cycles.table.add(cycle_of(1), nullptr);
  cycles.table.add(cycle_of(2), nullptr);
  cycles.table.add(cycle_of(3), nullptr);
  cycles.add_force(3, sample_ns(3) + 300'000);
  cycles.add_force(2, sample_ns(3) + 400'000);  // overtaken by the force for sample 3
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const CycleRow& row = cycles.rows[i];
    EXPECT_EQ(row.sample, i + 1);
    EXPECT_EQ(row.wanted_n.z(), static_cast<double>(i + 1));
    EXPECT_DOUBLE_EQ(row.p_WP.z(), 0.201);
    EXPECT_TRUE(row.is_contact);
    EXPECT_EQ(row.object, 1);
    EXPECT_FALSE(row.is_local);
    EXPECT_EQ(row.buttons, 5U);
  }
  EXPECT_NEAR(cycles.rows[0].sample_t_s, 1e-3, 1e-12);
  EXPECT_NEAR(cycles.rows[1].v_WD.x(), 0.1, 1e-9);
  EXPECT_NEAR(cycles.rows[1].round_trip_s, 1.4e-3, 1e-12);
  EXPECT_EQ(cycles.rows[2].missed, 2U);
}

TEST(CycleTable, ARowWhoseForceNeverComesIsThereWithoutOne) {
  TableWithRows cycles;
  cycles.table.add(cycle_of(1), nullptr);
  cycles.table.add(cycle_of(2), nullptr);
  cycles.add_force(2, sample_ns(2) + 300'000);
  EXPECT_TRUE(cycles.rows.empty()) << "in the order of the samples";
  cycles.table.add(cycle_of(6000), nullptr);
  ASSERT_EQ(cycles.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(cycles.rows[0].wanted_n.x()));
  EXPECT_TRUE(std::isnan(cycles.rows[0].round_trip_s));
  EXPECT_FALSE(cycles.rows[0].is_contact);
  const auto contact_column = std::ranges::find(cycle_columns(), std::string_view("contact"), &CycleColumn::name);
  ASSERT_NE(contact_column, cycle_columns().end());
  EXPECT_TRUE(std::isnan(contact_column->of(cycles.rows[0]))) << "not known";
  EXPECT_FALSE(std::isnan(contact_column->of(cycles.rows[1])));
  cycles.table.finish();
  EXPECT_EQ(cycles.rows.size(), 3U);
}

TEST(CycleTable, LocalForcesEventsAndOlderRecordings) {
  TableWithRows cycles;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  cycles.table.add(fault, nullptr);
  fault.fault = SessionFault::speed;
  cycles.table.add(fault, nullptr);
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 1e-3, 0.0), 6};
  cycles.table.add(local, nullptr);
  SessionEntry old = cycle_of(2);
  old.cycle.device.reset();
  cycles.table.add(old, nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 1U);
  EXPECT_EQ(cycles.rows[0].event, "clamped speed");
  EXPECT_TRUE(cycles.rows[0].is_local);
  EXPECT_EQ(cycles.rows[0].object, 6);
  EXPECT_TRUE(cycles.rows[0].is_contact);
  EXPECT_EQ(cycles.rows[0].wanted_n.y(), 2.0);
  EXPECT_DOUBLE_EQ(cycles.rows[0].p_WP.y(), 1e-3);
  EXPECT_EQ(cycles.table.without_sample(), 1U);
}

TEST(CycleTable, AGapIsNamedAndCounted) {
  TableWithRows cycles;
  for (const std::uint64_t sample : {40U, 41U, 157U, 158U, 158U, 160U}) cycles.table.add(cycle_of(sample), nullptr);
  cycles.table.finish();
  std::vector<std::uint64_t> lost_by_row;
  for (const CycleRow& row : cycles.rows) lost_by_row.push_back(row.lost);
  EXPECT_EQ(lost_by_row, (std::vector<std::uint64_t>{0, 0, 115, 0, 0, 1})) << "what was before a flight record is not a gap";
  EXPECT_EQ(cycles.table.lost(), 116U);
  EXPECT_EQ(cycles.table.gaps(), 2U);
}

TEST(CycleTable, AMarkerIsInTheRowOfItsSample) {
  TableWithRows cycles;
  cycles.table.add(marker_of(1, "begin"), nullptr);  // within the cycle, as usual
  cycles.table.add(cycle_of(1), nullptr);
  cycles.add_force(1, sample_ns(1) + 250'000);
  cycles.table.add(marker_of(1, "after its force"), nullptr);
  cycles.table.add(marker_of(2, "of a lost row"), nullptr);
  cycles.table.add(cycle_of(4), nullptr);
  cycles.table.add(marker_of(5, "at the end"), nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 2U);
  EXPECT_EQ(cycles.rows[0].markers, (std::vector<std::string>{"begin", "after its force"}));
  EXPECT_EQ(cycles.rows[1].markers, (std::vector<std::string>{"of a lost row", "at the end"}));
  TableWithRows empty;
  empty.table.add(marker_of(5, "without a row"), nullptr);
  empty.table.finish();
  EXPECT_TRUE(empty.rows.empty());
}

// As when `--overrun stop` ends a session: the fault is the last entry.
TEST(CycleTable, AFaultAfterTheLastCycleIsNotLost) {
  TableWithRows cycles;
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{};
  cycles.table.add(local, nullptr);
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::overrun;
  cycles.table.add(fault, nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 1U);
  EXPECT_EQ(cycles.rows[0].event, "overrun");
}

TEST(CycleTable, WithoutAForceItsColumnsAreNotKnown) {
  TableWithRows cycles;
  cycles.table.add(cycle_of(1), nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 1U);
  const CycleRow& row = cycles.rows[0];
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
  TableWithRows cycles;
  cycles.table.add(cycle_of(4), nullptr);
  SessionEntry again = cycle_of(5);
  again.cycle.device->time_ns = sample_ns(4);
  cycles.table.add(again, nullptr);
  SessionEntry earlier = cycle_of(6);
  earlier.cycle.device->time_ns = sample_ns(3);
  cycles.table.add(earlier, nullptr);
  cycles.table.add(cycle_of(7), nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(cycles.rows[i].v_WD, Vec3(0.0, 0.0, 0.0)) << i;
  EXPECT_NEAR(cycles.rows[3].v_WD.x(), 1e-4 / 4e-3, 1e-9);
}

TEST(CycleTable, TheFirstForceOfASampleIsTheOneThatActed) {
  TableWithRows cycles;
  cycles.table.add(cycle_of(1), nullptr);
  cycles.table.add(cycle_of(3), nullptr);
  cycles.add_force(2, sample_ns(3));  // for a sample that the recording lacks
  ForceCommand second = force_of(3);
  cycles.add_force(3, sample_ns(3) + 250'000);
  second.force_n = Vec3(9.0, 9.0, 9.0);
  const auto [entry, datagram] = arrival_of(second, sample_ns(3) + 400'000);
  cycles.table.add(entry, &datagram);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(cycles.rows[0].wanted_n.z()));
  EXPECT_EQ(cycles.rows[1].wanted_n, Vec3(0.0, 0.0, 3.0));
  EXPECT_NEAR(cycles.rows[1].round_trip_s, 2.5e-4, 1e-12);
}

// Only a force that the hub received can act; a force that it sent is not a reply to it.
TEST(CycleTable, AForceThatWasSentIsNoReply) {
  TableWithRows cycles;
  cycles.table.add(cycle_of(1), nullptr);
  auto [entry, datagram] = arrival_of(force_of(1), sample_ns(1) + 250'000);
  entry.kind = SessionEntry::Kind::sent;
  cycles.table.add(entry, &datagram);
  cycles.table.finish();
  EXPECT_TRUE(std::isnan(cycles.rows.at(0).wanted_n.z()));
}

// One more drops the oldest.
TEST(CycleTable, AtMost64ForcesWaitForTheirCycles) {
  for (const std::uint64_t early_forces : {64U, 65U}) {
    TableWithRows cycles;
    for (std::uint64_t sample = 1; sample <= early_forces; ++sample) cycles.add_force(sample, sample_ns(sample));
    for (std::uint64_t sample = 1; sample <= early_forces; ++sample) cycles.table.add(cycle_of(sample), nullptr);
    cycles.table.finish();
    ASSERT_EQ(cycles.rows.size(), early_forces);
    EXPECT_EQ(std::isnan(cycles.rows[0].wanted_n.z()), early_forces == 65U);
    for (std::size_t i = 1; i < early_forces; ++i) ASSERT_EQ(cycles.rows[i].wanted_n.z(), static_cast<double>(i + 1));
  }
}

TEST(CycleTable, ALocalForceReplacesThatOfTheHapticsNode) {
  TableWithRows cycles;
  for (const double force_n : {0.0, 0.3}) {
    SessionEntry local = cycle_of(force_n > 0.0 ? 2 : 1);
    local.cycle.device->q_WT = Quat(0.6, 0.8, 0.0, 0.0);
    local.cycle.local = CycleLocal{Vec3(0.0, force_n, 0.0), Vec3::Zero(), 2};
    cycles.table.add(local, nullptr);
  }
  cycles.add_force(2, sample_ns(2) + 100'000);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 2U);
  EXPECT_FALSE(cycles.rows[0].is_contact) << "no force";
  EXPECT_TRUE(cycles.rows[1].is_contact);
  EXPECT_EQ(cycles.rows[1].wanted_n.y(), 0.3) << "not that of the haptics node, which came as well";
  EXPECT_EQ(cycles.rows[1].wanted_nm, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(cycles.rows[1].q_WP.coeffs(), Quat(0.6, 0.8, 0.0, 0.0).coeffs());
}

// A row is passed on when no force can come in time any more: after more than five seconds, not at exactly five seconds.
TEST(CycleTable, ARowWaitsForItsForceAsLongAsItMayCome) {
  TableWithRows cycles;
  cycles.table.add(cycle_of(1), nullptr);
  cycles.table.add(cycle_of(2), nullptr);
  SessionEntry later = marker_of(2, "later");
  later.time_ns = cycle_of(1).time_ns + 5'000'000'000;
  cycles.table.add(later, nullptr);
  EXPECT_TRUE(cycles.rows.empty());
  later.time_ns += 1;
  cycles.table.add(later, nullptr);
  EXPECT_EQ(cycles.rows.size(), 1U);
  EXPECT_EQ(cycles.table.rows(), 1U);
  cycles.table.finish();
  EXPECT_EQ(cycles.table.rows(), 2U);
}

TEST(CycleTable, AFaultAfterTheLastCycleFollowsThoseOfTheCycle) {
  TableWithRows cycles;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  cycles.table.add(fault, nullptr);
  cycles.table.add(cycle_of(1), nullptr);
  fault.fault = SessionFault::overrun;
  cycles.table.add(fault, nullptr);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 1U);
  EXPECT_EQ(cycles.rows[0].event, "clamped overrun");
}

TEST(CycleTable, TimesOfAHostileFileDoNoHarm) {
  TableWithRows cycles;
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns / 2;
    cycles.table.add(entry, nullptr);
  }
  cycles.table.finish();
  EXPECT_EQ(cycles.rows.size(), 3U);
  for (const CycleRow& row : cycles.rows) EXPECT_TRUE(std::isfinite(row.sample_t_s) && row.v_WD.allFinite());
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
  TableWithRows cycles;
  SessionEntry cycle = cycle_of(1);
  cycle.cycle.device->q_WT = Quat(0.6, 0.8, 0.0, 0.0);
  cycle.cycle.written_nm = Vec3(0.25, 0.0, -0.125);
  cycles.table.add(cycle, nullptr);
  ForceCommand force = force_of(1);
  force.torque_nm = Vec3(0.5, 0.0, -0.25);
  force.visual_turn = Vec3(0.0, 0.0, 0.3);
  const auto [entry, datagram] = arrival_of(force, sample_ns(1) + 250'000);
  cycles.table.add(entry, &datagram);
  cycles.table.finish();
  ASSERT_EQ(cycles.rows.size(), 1U);
  const CycleRow& row = cycles.rows[0];
  EXPECT_EQ(row.wanted_nm, Vec3(0.5, 0.0, -0.25));
  EXPECT_EQ(row.written_nm, Vec3(0.25, 0.0, -0.125));
  const Quat expected = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())) * Quat(0.6, 0.8, 0.0, 0.0);
  EXPECT_LT((row.q_WP.coeffs() - expected.coeffs()).norm(), 1e-12) << "turned in W from how the stylus is held";
}

}  // namespace
}  // namespace hapton
