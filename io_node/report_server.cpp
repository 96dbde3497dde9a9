#include "io_node/report_server.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace hapton {

void ReportServer::accept(std::size_t peer, const ReportRequest& request) noexcept {
  if (peer >= waiting_.size()) return;
  waiting_[peer] = Waiting{request, texts_.value().revision};
  if (request.revision == 0) is_requested_.store(true, std::memory_order_release);
}

void ReportServer::serve(HubPeers& peers) noexcept {
  texts_.take();
  for (std::size_t n = 0; n < waiting_.size(); ++n) {
    const std::size_t peer = next_peer_;
    next_peer_ = (next_peer_ + 1) % waiting_.size();
    if (waiting_[peer] && reply(peers, peer)) {
      waiting_[peer].reset();
      return;
    }
  }
}

bool ReportServer::reply(HubPeers& peers, std::size_t peer) noexcept {
  const Waiting& waiting = *waiting_[peer];
  const Texts& texts = texts_.value();
  const bool is_available = waiting.request.revision == 0 ? texts.revision > waiting.newer_than : texts.revision != 0;
  if (!is_available) return false;
  // If the report is newer than the requested one, its first part is sent, which names the new revision.
  const std::uint32_t part_number = waiting.request.revision == texts.revision ? waiting.request.part : 0;
  const std::string_view text = waiting.request.document == ReportDocument::csv ? texts.csv : texts.json;
  const std::size_t part_bytes = part_.text.size();
  const auto parts = static_cast<std::uint32_t>((text.size() + part_bytes - 1) / part_bytes);
  if (part_number >= parts) return true;  // nothing to send
  const std::string_view piece = text.substr(part_number * part_bytes, part_bytes);
  part_.document = waiting.request.document;
  part_.revision = texts.revision;
  part_.part = part_number;
  part_.parts = parts;
  part_.size = static_cast<std::uint16_t>(piece.size());
  std::copy(piece.begin(), piece.end(), part_.text.begin());
  peers.send_to(peer, part_);
  return true;
}

void ReportServer::publish(std::string json, std::string csv) {
  Texts& draft = texts_.draft();
  draft.revision = ++revision_;
  draft.json = std::move(json);
  draft.csv = std::move(csv);
  texts_.publish_draft();
}

}  // namespace hapton
