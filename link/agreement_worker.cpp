#include "link/agreement_worker.h"

#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sodium.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "runtime/handoff_ring.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

using seal::store;

noise::Key make_ephemeral_secret() noexcept {
  noise::Key secret;
  randombytes_buf(secret.data(), secret.size());
  return secret;
}

void begin(AgreementTask& task) noexcept {
  noise::Key secret = make_ephemeral_secret();
  task.state.begin(task.psk, task.prologue, secret);
  sodium_memzero(secret.data(), secret.size());
}

void make_request(AgreementTask& task) noexcept {
  begin(task);
  task.state.write_first({}, task.first.data());
  task.is_valid = true;
}

void take_keys(AgreementTask& task) noexcept {
  noise::TransportKeys keys = task.state.split();
  task.keys.client_to_hub = keys.initiator_to_responder;
  task.keys.hub_to_client = keys.responder_to_initiator;
  sodium_memzero(&keys, sizeof keys);
  task.state.wipe();
}

void read_reply(AgreementTask& task) noexcept {
  std::array<std::uint8_t, sizeof task.connection> payload;
  task.is_valid = task.state.read_second(task.second, payload.data());
  if (!task.is_valid) return;
  task.connection = seal::load<std::uint32_t>(payload.data());
  take_keys(task);
}

void reply_to_request(AgreementTask& task) noexcept {
  begin(task);
  std::array<std::uint8_t, sizeof task.connection> payload;
  store(task.connection, payload.data());
  std::array<std::uint8_t, 1> none;
  task.is_valid = task.state.read_first(task.first, none.data()) && task.state.write_second(payload, task.second.data());
  if (task.is_valid) take_keys(task);
}

// A thread inherits the priority of its creator; this one must never keep a real-time loop from its CPU.
void drop_realtime_priority() noexcept {
  const sched_param none = {};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &none);
  pthread_setname_np(pthread_self(), "hapton-keys");
}

}  // namespace

void run_agreement(AgreementTask& task) noexcept {
  task.is_valid = false;
  switch (task.kind) {
    case AgreementTask::Kind::make_request:
      make_request(task);
      break;
    case AgreementTask::Kind::read_reply:
      read_reply(task);
      break;
    case AgreementTask::Kind::reply_to_request:
      reply_to_request(task);
      break;
  }
  seal::wipe(task.psk);
}

struct AgreementWorker::Queues {
  HandoffRing<AgreementTask, kCapacity> requested;
  HandoffRing<AgreementTask, kCapacity> done;
  sem_t wake = {};
  std::atomic<bool> ends{false};
  std::thread thread;
};

AgreementWorker::AgreementWorker(Where where) : queues_(std::make_unique<Queues>()) {
  sem_init(&queues_->wake, 0, 0);
  if (where == Where::own_thread) queues_->thread = start_thread([this] { work(); });
}

AgreementWorker::~AgreementWorker() {
  if (queues_->thread.joinable()) {
    queues_->ends.store(true, std::memory_order_release);
    sem_post(&queues_->wake);
    queues_->thread.join();
  }
  sem_destroy(&queues_->wake);
}

void AgreementWorker::work() noexcept {
  drop_realtime_priority();
  while (true) {
    while (sem_wait(&queues_->wake) != 0) {
    }
    if (queues_->ends.load(std::memory_order_acquire)) return;
    AgreementTask task;
    if (!queues_->requested.pop(task)) continue;
    run_agreement(task);
    queues_->done.push(task);  // has room: at most kCapacity tasks are pending
  }
}

bool AgreementWorker::submit(const AgreementTask& task) noexcept {
  if (pending_count_ == kCapacity) return false;
  ++pending_count_;
  if (queues_->thread.joinable()) {
    queues_->requested.push(task);
    sem_post(&queues_->wake);
  } else {
    AgreementTask done = task;
    run_agreement(done);
    queues_->done.push(done);
  }
  return true;
}

bool AgreementWorker::take(AgreementTask& task) noexcept {
  if (!queues_->done.pop(task)) return false;
  --pending_count_;
  return true;
}

}  // namespace hapton
