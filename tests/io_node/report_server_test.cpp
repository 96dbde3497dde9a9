#include "io_node/report_server.h"

#include <gtest/gtest.h>

#include "tests/io_node/scripted_endpoint.h"

namespace hapton {
namespace {

constexpr std::uint64_t kReportSession = 5;
constexpr std::size_t kPartBytes = ReportPart{}.text.size();

struct ReportServerTest : testing::Test {
  SimulatedClock clock{1'000'000'000};
  ScriptedEndpoint endpoint{clock};
  HubPeers peers{endpoint, clock, kReportSession, 1000.0};
  ReportServer report_server;
  std::vector<std::pair<std::uint16_t, ReportPart>> sent_parts;

  void SetUp() override {
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) {
      if (const auto* part = std::get_if<ReportPart>(&datagram.message)) sent_parts.emplace_back(to.port, *part);
    };
  }

  // Joins as a tool at this port; returns its slot.
  std::size_t join(std::uint16_t port) {
    endpoint.arrive(clock.now_ns(), {{9}, port}, {{0, 100ULL + port, 1, 0}, Hello{NodeRole::tool}});
    Datagram datagram;
    return peers.receive(datagram, clock.now_ns()).peer;
  }

  std::string text_of_part(std::size_t n) const { return {sent_parts.at(n).second.text.data(), sent_parts.at(n).second.size}; }
};

TEST_F(ReportServerTest, AFreshReportIsWaitedForAndHandedOutInParts) {
  const std::size_t tool = join(1);
  report_server.accept(tool, {ReportDocument::json, 0, 0});
  report_server.serve(peers);
  EXPECT_TRUE(sent_parts.empty());
  EXPECT_TRUE(report_server.take_request());
  EXPECT_FALSE(report_server.take_request());

  const std::string json = std::string(kPartBytes, 'a') + std::string(kPartBytes, 'b') + "c";
  report_server.publish(json, "csv");
  report_server.serve(peers);
  report_server.serve(peers);
  ASSERT_EQ(sent_parts.size(), 1U);
  EXPECT_EQ(sent_parts[0].second.parts, 3U);
  EXPECT_EQ(sent_parts[0].second.part, 0U);
  const std::uint32_t revision = sent_parts[0].second.revision;
  std::string whole = text_of_part(0);
  for (std::uint32_t part = 1; part < 3; ++part) {
    report_server.accept(tool, {ReportDocument::json, revision, part});
    report_server.serve(peers);
    whole += text_of_part(part);
  }
  EXPECT_EQ(whole, json);
  report_server.accept(tool, {ReportDocument::csv, revision, 0});
  report_server.serve(peers);
  EXPECT_EQ(text_of_part(3), "csv");
  EXPECT_FALSE(report_server.take_request());
}

TEST_F(ReportServerTest, AReaderOfAnOldReportGetsTheBeginningOfTheNewOne) {
  const std::size_t tool = join(1);
  report_server.publish(std::string(2000, 'a'), "");
  report_server.serve(peers);
  report_server.publish("new", "");
  report_server.accept(tool, {ReportDocument::json, 1, 2});
  report_server.serve(peers);
  ASSERT_EQ(sent_parts.size(), 1U);
  EXPECT_EQ(sent_parts[0].second.revision, 2U);
  EXPECT_EQ(sent_parts[0].second.part, 0U);
  EXPECT_EQ(text_of_part(0), "new");
}

TEST_F(ReportServerTest, OneDatagramACycleGoesToAllRequestersInTurn) {
  const std::size_t first = join(1);
  const std::size_t second = join(2);
  report_server.publish("text", "");
  for (const std::size_t tool : {first, second}) report_server.accept(tool, {ReportDocument::json, 1, 0});
  report_server.serve(peers);
  EXPECT_EQ(sent_parts.size(), 1U);
  report_server.serve(peers);
  ASSERT_EQ(sent_parts.size(), 2U);
  EXPECT_NE(sent_parts[0].first, sent_parts[1].first);
}

TEST_F(ReportServerTest, InvalidRequestsGetNoReply) {
  const std::size_t tool = join(1);
  report_server.publish("text", "");
  report_server.accept(tool, {ReportDocument::json, 1, 7});
  report_server.accept(1000, {ReportDocument::json, 1, 0});
  report_server.accept(tool + 1, {ReportDocument::json, 1, 0});  // no tool has this slot
  for (int n = 0; n < 5; ++n) report_server.serve(peers);
  EXPECT_TRUE(sent_parts.empty());
}

}  // namespace
}  // namespace hapton
