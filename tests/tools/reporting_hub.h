#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <variant>

#include "tests/tools/replying_hub.h"
#include "tools/live/hub_report.h"

namespace hapton {

// A hub in its own thread, which nodes can join. It sends reports of one part each, and nothing else.
class ReportingHub {
 public:
  // Makes the report with this number; numbers count from 1.
  using Make = std::function<HubReport(int number)>;
  // Called in the hub's thread after a whole report was sent. If it returns false, the hub is silent from then on.
  using After = std::function<bool()>;

  explicit ReportingHub(
      Make make, After after = [] { return true; })
      : make_(std::move(make)), after_(std::move(after)) {}

  std::string address() const { return hub_.address(); }
  std::string key_file() const { return hub_.key_file(); }

 private:
  bool reply(HubPeers& peers, std::size_t peer, const ReportRequest& request) {
    const bool is_table = request.document == ReportDocument::csv;
    if (!is_table) ++number_;
    const HubReport report = make_(number_);
    const std::string& text = is_table ? report.csv : report.json;
    ReportPart part;
    part.document = request.document;
    part.revision = static_cast<std::uint32_t>(number_);
    part.parts = 1;
    part.size = static_cast<std::uint16_t>(std::min(text.size(), part.text.size()));
    std::copy_n(text.begin(), part.size, part.text.begin());
    peers.send_to(peer, part);
    return !is_table || after_();
  }

  Make make_;
  After after_;
  int number_ = 0;
  ReplyingHub hub_{[this](HubPeers& peers, std::size_t peer, const Message& message) {
    const auto* request = std::get_if<ReportRequest>(&message);
    return request == nullptr || reply(peers, peer, *request);
  }};
};

}  // namespace hapton
