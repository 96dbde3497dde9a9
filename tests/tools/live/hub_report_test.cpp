#include "tools/live/hub_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>

#include "tests/support/one_line.h"
#include "tests/tools/replying_hub.h"

namespace hapton {
namespace {

// Sends a part of a report.
void send_part(HubPeers& peers, std::size_t peer, ReportPart part, const std::string& text) {
  part.size = static_cast<std::uint16_t>(text.size());
  std::copy(text.begin(), text.end(), part.text.begin());
  peers.send_to(peer, part);
}

Result<HubReport> read_from(const ReplyingHub& hub) {
  const auto reader = HubReader::open(hub.address(), hub.key_file());
  if (!reader) return tl::unexpected(reader.error());
  return (*reader)->read();
}

// Reads from a hub that makes a newer report before it sends a table, for each of the first `outdated_tables` tables.
Result<HubReport> read_from_hasty_hub(std::uint32_t outdated_tables, std::uint32_t parts = 1) {
  std::uint32_t revision = 0;
  const ReplyingHub hub([&](HubPeers& peers, std::size_t peer, const Message& message) {
    const auto* request = std::get_if<ReportRequest>(&message);
    if (request == nullptr) return true;
    const bool is_table = request->document == ReportDocument::csv;
    if (revision == 0 || (is_table && revision <= outdated_tables)) ++revision;
    ReportPart part;
    part.document = request->document;
    part.revision = revision;
    part.parts = parts;
    send_part(peers, peer, part, (is_table ? "table " : "report ") + std::to_string(revision));
    return true;
  });
  return read_from(hub);
}

TEST(HubReport, BothDocumentsAreOfOneMomentThoughAnotherReportCameBetween) {
  const auto report = read_from_hasty_hub(2);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->json, "report 3");
  EXPECT_EQ(report->csv, "table 3");
}

TEST(HubReport, OfAHubThatNeverRestsIsGivenUpInALine) {
  const auto report = read_from_hasty_hub(1'000'000);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().what.find("faster than they can be read"), std::string::npos) << report.error().what;
  EXPECT_THAT(report.error().what, IsOneLine());
}

TEST(HubReport, OfMorePartsThanAnyReportHasIsNotRead) {
  const auto report = read_from_hasty_hub(0, 4'000'000'000U);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().what.find("4000000000 parts"), std::string::npos) << report.error().what;
}

// The hub makes the second report while the first one is being read.
TEST(HubReport, PartsOfAReportThatANewerOneReplacedAreNotInIt) {
  std::uint32_t revision = 1;
  const ReplyingHub hub([&](HubPeers& peers, std::size_t peer, const Message& message) {
    const auto* request = std::get_if<ReportRequest>(&message);
    if (request == nullptr) return true;
    if (request->revision == 1 && request->part == 1) revision = 2;
    ReportPart part;
    part.document = request->document;
    part.revision = revision;
    part.parts = 2;
    part.part = request->revision == revision ? request->part : 0;
    send_part(peers, peer, part, std::to_string(revision) + (part.part == 0 ? " begins, " : " ends"));
    return true;
  });
  const auto report = read_from(hub);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->json, "2 begins, 2 ends");
  EXPECT_EQ(report->csv, "2 begins, 2 ends");
}

}  // namespace
}  // namespace hapton
