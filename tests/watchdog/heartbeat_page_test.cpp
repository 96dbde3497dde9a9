#include "watchdog/heartbeat_page.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace hapton {
namespace {

std::string path_in(const HeartbeatPage& page) {
  std::string path;
  for (const auto& letter : page.path) {
    if (letter.load() == '\0') return path;
    path += letter.load();
  }
  return "not ended";
}

std::vector<std::uint8_t> report_of(std::size_t size) {
  std::vector<std::uint8_t> report(size);
  for (std::size_t n = 0; n < size; ++n) report[n] = static_cast<std::uint8_t>(n + 1);
  return report;
}

TEST(HeartbeatPage, BeginsWithNothingToCut) {
  const auto page = std::make_unique<HeartbeatPage>();
  EXPECT_EQ(page->magic.load(), HeartbeatPage::kMagic);
  EXPECT_EQ(page->means.load(), CutMeans::none);
  EXPECT_EQ(page->heartbeat_ns.load(), 0);
  EXPECT_EQ(page->force_sample_ns.load(), 0);
  EXPECT_EQ(page->is_cut.load(), 0U);
  EXPECT_EQ(page->is_cut_within.load(), 0U);
  EXPECT_EQ(page->generation.load(), 0U);
  EXPECT_EQ(page->report_size.load(), 0U);
  EXPECT_EQ(page->cuts.load(), 0U);
  for (const auto& force : page->motors_n) EXPECT_EQ(force.load(), 0.0);
}

TEST(HeartbeatPage, HoldsPathAndReportOfADevice) {
  const auto page = std::make_unique<HeartbeatPage>();
  const auto report = report_of(9);
  page->set_hid("/dev/hidraw12", report);
  EXPECT_EQ(page->means.load(), CutMeans::hid);
  EXPECT_EQ(page->generation.load(), 2U) << "odd only while it is written";
  EXPECT_EQ(path_in(*page), "/dev/hidraw12");
  ASSERT_EQ(page->report_size.load(), 9U);
  for (std::size_t n = 0; n < report.size(); ++n) EXPECT_EQ(page->report[n].load(), report[n]) << n;
  EXPECT_EQ(page->report[9].load(), 0) << "nothing beyond the report";
  page->set_hid("/dev/x", report_of(2));
  EXPECT_EQ(path_in(*page), "/dev/x") << "nothing is left of a longer one";
  EXPECT_EQ(page->report_size.load(), 2U);
  EXPECT_EQ(page->generation.load(), 4U);
}

TEST(HeartbeatPage, APathOrReportThatDoesNotFitLeavesNoMeans) {
  struct Row {
    std::size_t path, report;
    bool fits;
  };
  constexpr std::size_t kPath = HeartbeatPage::kMaxPath;
  constexpr std::size_t kReport = HeartbeatPage::kMaxReport;
  const Row rows[] = {{kPath - 1, 1, true}, {kPath, 1, false}, {1, kReport, true}, {1, kReport + 1, false}, {kPath - 1, kReport, true}};
  for (const Row& row : rows) {
    SCOPED_TRACE(testing::Message() << row.path << ", " << row.report);
    const auto page = std::make_unique<HeartbeatPage>();
    page->set_hid("/dev/before", report_of(3));
    const std::string path(row.path, 'p');
    const auto report = report_of(row.report);
    page->set_hid(path, report);
    EXPECT_EQ(page->means.load(), row.fits ? CutMeans::hid : CutMeans::none);
    EXPECT_EQ(page->report_size.load(), row.fits ? row.report : 0U);
    EXPECT_EQ(path_in(*page), row.fits ? path : "/dev/before");
    if (row.fits) {
      EXPECT_EQ(page->report[row.report - 1].load(), report.back());
    }
    EXPECT_EQ(page->generation.load(), 4U);
  }
}

}  // namespace
}  // namespace hapton
