#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "link/key_schedule.h"
#include "link/noise.h"
#include "link/seal_format.h"

namespace hapton {

// One part of a handshake that needs an X25519 agreement or key pair: too slow for a real-time loop. Its secrets are wiped on
// destruction.
struct AgreementTask {
  enum class Kind : std::uint8_t {
    make_request,      // node: psk, prologue -> first, state
    read_reply,        // node: state, second -> keys, connection
    reply_to_request,  // hub: psk, prologue, first, connection -> second, keys
  };
  Kind kind = Kind::make_request;
  bool went_well = false;         // of a finished one
  std::uint32_t number = 0;       // the caller's own
  std::uint32_t connection = 0;   // the session's number
  std::int64_t timestamp_ns = 0;  // the caller's own
  seal::Secret psk = {};
  std::array<std::uint8_t, seal::kPrologueBytes> prologue = {};
  std::array<std::uint8_t, seal::kFirstBytes> first = {};
  std::array<std::uint8_t, seal::kSecondBytes> second = {};
  noise::HandshakeState state;
  seal::SessionKeys keys;

  AgreementTask() = default;
  ~AgreementTask() { seal::wipe(psk); }
  AgreementTask(const AgreementTask&) = default;
  AgreementTask& operator=(const AgreementTask&) = default;
};

// Does one task, here and now. No heap, lock or throw.
void run_agreement(AgreementTask& task) noexcept;

// Does tasks for one caller: in its own thread at ordinary priority, so that the caller continues at once, or,
// for tests and callers without deadlines, in the caller's. RT: submit and take yes with its own thread
// (wait-free; one system call wakes a sleeping thread), no without. Construction set-up only. Threads: one
// caller.
class AgreementWorker {
 public:
  enum class Where : std::uint8_t { caller, own_thread };
  static constexpr std::size_t kCapacity = 16;  // pending tasks, including results not taken yet

  explicit AgreementWorker(Where where);
  ~AgreementWorker();
  AgreementWorker(const AgreementWorker&) = delete;
  AgreementWorker& operator=(const AgreementWorker&) = delete;

  // False if too many are pending; the task is then dropped.
  bool submit(const AgreementTask& task) noexcept;
  // The next one that is finished, in the order of submission.
  bool take(AgreementTask& task) noexcept;
  // Submitted and not taken yet.
  std::size_t under_way() const noexcept { return under_way_; }

 private:
  struct Desk;
  void work() noexcept;

  std::unique_ptr<Desk> desk_;
  std::size_t under_way_ = 0;
};

}  // namespace hapton
