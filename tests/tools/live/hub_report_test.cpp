#include "tools/live/hub_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <variant>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// A hub whose tables each belong to a later report than the previous one, until a given number have been requested.
class HastyHub {
 public:
  HastyHub(const LinkKey& key, std::uint32_t hasty, std::uint32_t parts)
      : key_(key), hasty_(hasty), parts_(parts), thread_([this] { run(); }) {}
  ~HastyHub() {
    ends_ = true;
    thread_.join();
  }
  std::string address() const { return to_string(endpoint_->local_address()); }

 private:
  void run() {
    SealedHub sealed(*endpoint_, clock_, key_);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    while (!ends_) {
      const PeerEvent event = peers.receive(datagram, clock_.now_ns() + kNanosecondsPerMillisecond);
      const auto* request = std::get_if<ReportRequest>(&datagram.message);
      if (event.kind == PeerEvent::Kind::message && request != nullptr) reply(peers, event.peer, *request);
    }
  }

  void reply(HubPeers& peers, std::size_t peer, const ReportRequest& request) {
    const bool is_table = request.document == ReportDocument::csv;
    if (revision_ == 0 || (is_table && revision_ <= hasty_)) ++revision_;
    ReportPart part;
    part.document = request.document;
    part.revision = revision_;
    part.parts = parts_;
    const std::string text = (is_table ? "table " : "report ") + std::to_string(revision_);
    part.size = static_cast<std::uint16_t>(text.size());
    std::copy(text.begin(), text.end(), part.text.begin());
    peers.send_to(peer, part);
  }

  LinkKey key_;
  std::uint32_t hasty_;
  std::uint32_t parts_;
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  std::uint32_t revision_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

Result<HubReport> read_from(std::uint32_t hasty, std::uint32_t parts = 1) {
  const ScratchFolder folder;
  const std::string key_file = (folder.path() / "key").string();
  if (const auto made = make_key_file(key_file); !made) return tl::unexpected(made.error());
  const HastyHub hub(*read_key_file(key_file), hasty, parts);
  const auto reader = HubReader::open(hub.address(), key_file);
  if (!reader) return tl::unexpected(reader.error());
  return (*reader)->read();
}

TEST(HubReport, BothDocumentsAreOfOneMomentThoughAnotherReportCameBetween) {
  const auto report = read_from(2);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->json, "report 3");
  EXPECT_EQ(report->csv, "table 3");
}

TEST(HubReport, OfAHubThatNeverRestsIsGivenUpInALine) {
  const auto report = read_from(1'000'000);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().what.find("faster than they can be read"), std::string::npos) << report.error().what;
}

TEST(HubReport, OfMorePartsThanAnyReportHasIsNotRead) {
  const auto report = read_from(0, 4'000'000'000U);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().what.find("4000000000 parts"), std::string::npos) << report.error().what;
}

// A hub whose reports have two parts. It makes the second report while the first one is being read.
class BusyHub {
 public:
  explicit BusyHub(const LinkKey& key) : key_(key), thread_([this] { run(); }) {}
  ~BusyHub() {
    ends_ = true;
    thread_.join();
  }
  std::string address() const { return to_string(endpoint_->local_address()); }

 private:
  void run() {
    SealedHub sealed(*endpoint_, clock_, key_);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    while (!ends_) {
      const PeerEvent event = peers.receive(datagram, clock_.now_ns() + kNanosecondsPerMillisecond);
      const auto* request = std::get_if<ReportRequest>(&datagram.message);
      if (event.kind == PeerEvent::Kind::message && request != nullptr) reply(peers, event.peer, *request);
    }
  }

  void reply(HubPeers& peers, std::size_t peer, const ReportRequest& request) {
    if (request.revision == 1 && request.part == 1) revision_ = 2;
    ReportPart part;
    part.document = request.document;
    part.revision = revision_;
    part.parts = 2;
    part.part = request.revision == revision_ ? request.part : 0;
    const std::string text = std::to_string(revision_) + (part.part == 0 ? " begins, " : " ends");
    part.size = static_cast<std::uint16_t>(text.size());
    std::copy(text.begin(), text.end(), part.text.begin());
    peers.send_to(peer, part);
  }

  LinkKey key_;
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  std::uint32_t revision_ = 1;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

TEST(HubReport, PartsOfAReportThatANewerOneReplacedAreNotInIt) {
  const ScratchFolder folder;
  const std::string key_file = (folder.path() / "key").string();
  ASSERT_TRUE(make_key_file(key_file));
  const BusyHub hub(*read_key_file(key_file));
  const auto reader = HubReader::open(hub.address(), key_file);
  ASSERT_TRUE(reader) << reader.error().what;
  const auto report = (*reader)->read();
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->json, "2 begins, 2 ends");
  EXPECT_EQ(report->csv, "2 begins, 2 ends");
}

}  // namespace
}  // namespace hapton
