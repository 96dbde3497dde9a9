#pragma once

#include <cstdint>
#include <variant>

#include "link/messages.h"
#include "link/sequence_tracker.h"

namespace hapton {

// For a program that turns the scene: the revision of the newest view that another node has set. RT: yes. Threads: one.
class OthersView {
 public:
  // Takes a message of the hub, which repeats the view in use. A view that a newer one overtook is ignored: with its smaller revision, the
  // program's next view would have no effect. own: the program's newest view.
  void take(const Message& message, Arrival arrival, const ViewTransform& own) noexcept {
    const auto* view = std::get_if<ViewTransform>(&message);
    if (view != nullptr && arrival == Arrival::newest && view->X_WS != own.X_WS) revision_ = view->revision;
  }
  // Call for another session of the hub, where revisions begin again.
  void forget() noexcept { revision_ = 0; }

  // 0: none.
  std::uint32_t revision() const noexcept { return revision_; }

 private:
  std::uint32_t revision_ = 0;
};

}  // namespace hapton
