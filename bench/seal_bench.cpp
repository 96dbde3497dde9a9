// The cost of a datagram between message and socket: encode, seal, open, decode. The budget for all four is 1.5 us.
//
//   build/release/bin/seal_bench                                     # --benchmark_filter='aes|chacha': the two ciphers alone
#include <benchmark/benchmark.h>

#include <sodium.h>

#include <array>
#include <cstdlib>

#include "link/codec.h"
#include "link/handshake.h"
#include "link/link_key.h"
#include "link/sealed_channel.h"

namespace hapton {
namespace {

using Bytes = std::array<std::byte, kMaxDatagramBytes>;

LinkKey make_key() {
  if (const auto started = seal::start_crypto(); !started) std::abort();
  return LinkKey::make_random();
}

struct Channels {
  Channels() {
    seal::ChannelKeys keys;
    keys.client_to_hub = make_key().bytes();
    keys.hub_to_client = make_key().bytes();
    client = SealedChannel(keys, 1, SealedChannel::Side::client);
    hub = SealedChannel(keys, 1, SealedChannel::Side::hub);
  }
  SealedChannel client;
  SealedChannel hub;
};

ForceCommand some_force() {
  return {.echo_sample = 123'456'789,
          .echo_sample_time_ns = 1'234'567'890'123'456,
          .force_n = Vec3(0.1, -1.2, 2.3),
          .visual_offset_m = Vec3(0.0011, -0.0012, 0.0013),
          .contact = true,
          .compute_ns = 700,
          .skipped_samples = 1,
          .view_revision = 7,
          .method_serial = 1,
          .replied_before = ~std::uint64_t{0}};
}

DeviceState some_state() {
  return {.sample = 123'456'789,
          .sample_time_ns = 1'234'567'890'123'456,
          .p_WD = Vec3(0.01, -0.02, 0.03),
          .q_WT = Quat(0.5, -0.5, 0.5, -0.5),
          .buttons = 3};
}

// Takes a message from its sender to its receiver, as HubPeers and HubClient do: encode, seal, open, decode.
template <class MessageType>
void encode_to_decode(benchmark::State& state, const MessageType& message) {
  Channels channels;
  Codec sender;
  Codec receiver;
  Bytes plain;
  Bytes sealed;
  Bytes opened;
  Datagram out{{1, 2, 3, 4}, {}};
  Datagram in;
  std::size_t bytes = 0;
  std::size_t size = 0;
  for (auto _ : state) {
    ++out.header.sequence;
    out.message = message;
    const std::size_t plain_size = sender.encode(out, plain);
    size = channels.client.seal(std::span(plain).first(plain_size), sealed);
    channels.hub.open(std::span(sealed).first(size), opened, bytes);
    if (receiver.decode(std::span(opened).first(bytes), in) != DecodeStatus::ok) state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(in);
  }
  state.counters["bytes"] = static_cast<double>(size);
}

void force_encode_to_decode(benchmark::State& state) { encode_to_decode(state, some_force()); }
void state_encode_to_decode(benchmark::State& state) { encode_to_decode(state, some_state()); }

void codec_alone(benchmark::State& state) {
  Codec codec;
  Bytes plain;
  Datagram out{{1, 2, 3, 4}, some_force()};
  Datagram in;
  for (auto _ : state) {
    const std::size_t size = codec.encode(out, plain);
    benchmark::DoNotOptimize(codec.decode(std::span(plain).first(size), in));
  }
}

void seal_alone(benchmark::State& state) {
  Channels channels;
  Bytes plain = {};
  Bytes sealed;
  for (auto _ : state) {
    benchmark::DoNotOptimize(channels.client.seal(std::span(plain).first(static_cast<std::size_t>(state.range(0))), sealed));
  }
}

void seal_and_open(benchmark::State& state) {
  Channels channels;
  Bytes plain = {};
  Bytes sealed;
  Bytes opened;
  std::size_t bytes = 0;
  for (auto _ : state) {
    const std::size_t size = channels.client.seal(std::span(plain).first(static_cast<std::size_t>(state.range(0))), sealed);
    benchmark::DoNotOptimize(channels.hub.open(std::span(sealed).first(size), opened, bytes));
  }
}

// One of the two ciphers of libsodium that a sealed link could use, without the channel around it: sealing and opening.
void aes256_gcm(benchmark::State& state) {
  if (const auto started = seal::start_crypto(); !started) std::abort();
  const auto size = static_cast<unsigned long long>(state.range(0));
  const std::array<unsigned char, crypto_aead_aes256gcm_KEYBYTES> key = {1};
  std::array<unsigned char, crypto_aead_aes256gcm_NPUBBYTES> nonce = {};
  std::array<unsigned char, kMaxDatagramBytes> plain = {};
  std::array<unsigned char, kMaxDatagramBytes + crypto_aead_aes256gcm_ABYTES> sealed;
  alignas(16) crypto_aead_aes256gcm_state expanded;
  crypto_aead_aes256gcm_beforenm(&expanded, key.data());
  for (auto _ : state) {
    ++nonce[0];
    crypto_aead_aes256gcm_encrypt_afternm(sealed.data(), nullptr, plain.data(), size, nullptr, 0, nullptr, nonce.data(), &expanded);
    benchmark::DoNotOptimize(crypto_aead_aes256gcm_decrypt_afternm(
        plain.data(), nullptr, nullptr, sealed.data(), size + crypto_aead_aes256gcm_ABYTES, nullptr, 0, nonce.data(), &expanded));
  }
}

void chacha20_poly1305(benchmark::State& state) {
  if (const auto started = seal::start_crypto(); !started) std::abort();
  const auto size = static_cast<unsigned long long>(state.range(0));
  const std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_KEYBYTES> key = {1};
  std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_NPUBBYTES> nonce = {};
  std::array<unsigned char, kMaxDatagramBytes> plain = {};
  std::array<unsigned char, kMaxDatagramBytes + crypto_aead_chacha20poly1305_ietf_ABYTES> sealed;
  for (auto _ : state) {
    ++nonce[0];
    crypto_aead_chacha20poly1305_ietf_encrypt(sealed.data(), nullptr, plain.data(), size, nullptr, 0, nullptr, nonce.data(), key.data());
    benchmark::DoNotOptimize(crypto_aead_chacha20poly1305_ietf_decrypt(plain.data(), nullptr, nullptr, sealed.data(),
                                                                       size + crypto_aead_chacha20poly1305_ietf_ABYTES, nullptr, 0,
                                                                       nonce.data(), key.data()));
  }
}

// The cost of rejecting an unknown peer's datagram: here a forged one of a live session, in reject_request a request with another key.
void reject_forged(benchmark::State& state) {
  Channels channels;
  Bytes plain = {};
  Bytes sealed;
  Bytes opened;
  std::size_t bytes = 0;
  const std::size_t size = channels.client.seal(std::span(plain).first(150), sealed);
  sealed[40] ^= std::byte{1};  // a byte of the ciphertext
  for (auto _ : state) benchmark::DoNotOptimize(channels.hub.open(std::span(sealed).first(size), opened, bytes));
}

// Makes a handshake request of this client. A hub first checks the tag of a request, then whether the request is a replay.
std::array<std::byte, seal::kRequestBytes> make_request(ClientHandshake& client, std::int64_t now_ns) {
  std::array<std::byte, seal::kRequestBytes> request;
  client.begin();
  client.start_request(now_ns);
  if (client.poll(request) != ClientHandshake::Finished::request) std::abort();
  return request;
}

void reject_request(benchmark::State& state) {
  ClientHandshake unknown(RoleKey(make_key(), KeyRole::haptics), 1, AgreementWorker::Where::caller);
  HubHandshake hub(make_key(), AgreementWorker::Where::caller);
  const auto request = make_request(unknown, 1);
  for (auto _ : state) benchmark::DoNotOptimize(hub.check_request(request, {}, 1));
}

void reject_replayed_request(benchmark::State& state) {
  const LinkKey key = make_key();
  ClientHandshake node(RoleKey(key, KeyRole::haptics), 1, AgreementWorker::Where::caller);
  HubHandshake hub(key, AgreementWorker::Where::caller);
  const auto request = make_request(node, 1);
  hub.check_request(request, {}, 1);
  for (auto _ : state) benchmark::DoNotOptimize(hub.check_request(request, {}, 1));
}

// The hub's work for a valid request: it checks the request and hands it over to the worker thread. The key agreement runs in that thread;
// the benchmark waits for the result with its clock stopped.
void hand_over_request(benchmark::State& state) {
  const LinkKey key = make_key();
  ClientHandshake node(RoleKey(key, KeyRole::haptics), 1, AgreementWorker::Where::caller);
  HubHandshake hub(key, AgreementWorker::Where::own_thread);
  HubHandshake::Agreement agreement;
  std::int64_t now_ns = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const auto request = make_request(node, ++now_ns);
    state.ResumeTiming();
    benchmark::DoNotOptimize(hub.check_request(request, {}, 1));
    hub.agree(request, 1);
    state.PauseTiming();
    while (!hub.poll(agreement)) {
    }
    state.ResumeTiming();
  }
}

// The work of the worker thread, first at the node, then at the hub.
void worker_makes_request(benchmark::State& state) {
  AgreementTask task;
  for (auto _ : state) run_agreement(task);
}

void worker_replies_to_request(benchmark::State& state) {
  const LinkKey key = make_key();
  ClientHandshake node(RoleKey(key, KeyRole::haptics), 1, AgreementWorker::Where::caller);
  HubHandshake hub(key, AgreementWorker::Where::caller);
  const auto request = make_request(node, 1);
  HubHandshake::Agreement agreement;
  for (auto _ : state) {
    hub.agree(request, 1);
    if (!hub.poll(agreement) || !agreement.is_valid) state.SkipWithError("no agreement");
  }
}

BENCHMARK(force_encode_to_decode);
BENCHMARK(state_encode_to_decode);
BENCHMARK(codec_alone);
BENCHMARK(seal_alone)->Arg(150);
BENCHMARK(seal_and_open)->Arg(64)->Arg(150)->Arg(seal::kMaxPayloadBytes);
BENCHMARK(aes256_gcm)->Arg(64)->Arg(150);
BENCHMARK(chacha20_poly1305)->Arg(64)->Arg(150);
BENCHMARK(reject_forged);
BENCHMARK(reject_request);
BENCHMARK(reject_replayed_request);
BENCHMARK(hand_over_request)->Iterations(2000);
BENCHMARK(worker_makes_request);
BENCHMARK(worker_replies_to_request);

}  // namespace
}  // namespace hapton
