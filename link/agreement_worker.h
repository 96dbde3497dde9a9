#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "link/key_schedule.h"
#include "link/noise.h"
#include "link/seal_format.h"

namespace hapton {

// One step of a handshake that needs an X25519 key agreement or key pair, which is too slow for a real-time loop. The destructor wipes the
// secrets.
struct AgreementTask {
  // Which side does it: members that are read -> members that are written.
  enum class Kind : std::uint8_t {
    make_request,      // node: psk, prologue -> first, state
    read_reply,        // node: state, second -> keys, connection
    reply_to_request,  // hub: psk, prologue, first, connection -> second, keys
  };
  Kind kind = Kind::make_request;
  bool is_valid = false;          // set when the task is finished: the message was valid
  std::uint32_t number = 0;       // for the caller: comes back unchanged
  std::uint32_t connection = 0;   // the number of the session
  std::int64_t timestamp_ns = 0;  // for the caller: comes back unchanged
  seal::Secret psk = {};
  std::array<std::uint8_t, seal::kPrologueBytes> prologue = {};
  std::array<std::uint8_t, seal::kFirstBytes> first = {};  // the two messages of the Noise handshake (noise.h)
  std::array<std::uint8_t, seal::kSecondBytes> second = {};
  noise::HandshakeState state;
  seal::ChannelKeys keys;

  AgreementTask() = default;
  ~AgreementTask() { seal::wipe(psk); }
  AgreementTask(const AgreementTask&) = default;
  AgreementTask& operator=(const AgreementTask&) = default;
};

// Does one task in the calling thread, and wipes its psk. RT: no: without heap, lock or throw, but slow.
void run_agreement(AgreementTask& task) noexcept;

// Does tasks for one caller. own_thread: in a thread of ordinary priority, so that the caller continues at once. caller, for tests and
// callers without deadlines: in submit(). RT: with own_thread, submit and take yes (wait-free; one system call wakes the sleeping thread);
// with caller, no. Construction set-up only. Threads: one caller.
class AgreementWorker {
 public:
  enum class Where : std::uint8_t { caller, own_thread };
  static constexpr std::size_t kCapacity = 16;  // pending tasks, including results not taken yet

  explicit AgreementWorker(Where where);
  ~AgreementWorker();
  AgreementWorker(const AgreementWorker&) = delete;
  AgreementWorker& operator=(const AgreementWorker&) = delete;

  // False: kCapacity tasks are pending, and this one is dropped.
  bool submit(const AgreementTask& task) noexcept;
  // Gives the next finished task, in the order of submission. False: none is finished.
  bool take(AgreementTask& task) noexcept;
  // How many tasks are submitted and not yet taken.
  std::size_t pending_count() const noexcept { return pending_count_; }

 private:
  struct Queues;
  void work() noexcept;

  std::unique_ptr<Queues> queues_;
  std::size_t pending_count_ = 0;
};

}  // namespace hapton
