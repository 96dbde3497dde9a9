#include "link/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <set>
#include <type_traits>
#include <vector>

#include "link/endpoint.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::uint64_t kSeed = 20240611;

class RandomDatagrams {
 public:
  explicit RandomDatagrams(std::uint64_t seed) : random_(seed) { testing::Test::RecordProperty("seed", std::to_string(seed)); }

  Datagram draw(std::size_t kind) {
    Datagram datagram;
    datagram.header = {bits(), bits(), bits(), static_cast<std::int64_t>(bits())};
    datagram.message = draw_message(kind);
    return datagram;
  }

  std::uint64_t bits() { return random_(); }
  std::uint32_t bits32() { return static_cast<std::uint32_t>(random_()); }
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  bool flag() { return (random_() & 1U) != 0; }
  Vec3 vector() { return {number(-10, 10), number(-1e-6, 1e-6), number(-1e6, 1e6)}; }
  Quat rotation() { return Quat(number(-1, 1), number(-1, 1), number(-1, 1), number(0.1, 1)).normalized(); }
  float rate() { return static_cast<float>(number(0, 1e4)); }

  Message draw_message(std::size_t kind) {
    const auto time = static_cast<std::int64_t>(bits());
    switch (kind) {
      case 0:
        return Hello{static_cast<NodeRole>(1 + bits() % 4)};
      case 1:
        return Welcome{flag(), number(250, 1e4)};
      case 2:
        return Bye{};
      case 3:
        return draw_state(time);
      case 4:
        return ForceCommand{bits(), time, vector(), vector(), flag(), bits32(), bits32(), bits32(), bits32(), bits()};
      case 5:
        return draw_view();
      case 6:
        return ProbeState{bits(),
                          time,
                          vector(),
                          rotation(),
                          vector(),
                          vector(),
                          flag(),
                          bits32(),
                          rate(),
                          rate(),
                          rate(),
                          bits32(),
                          static_cast<ProbeStatus>(bits() % 7)};
      case 7:
        return Drawn{bits(), time, rate(), bits32(), bits32(), flag()};
      case 8:
        return HandTarget{flag(), vector()};
      case 9:
        return Settings{flag() ? 0.0 : number(kMinServoRateHz, kMaxServoRateHz), {'s', 'w', 'e', 'e', 'p'}, flag(), flag(), bits32()};
      case 10:
        return draw_setup();
      case 11:
        return ReportAsk{flag() ? ReportDocument::csv : ReportDocument::json, bits32(), bits32()};
      case 12:
        return draw_part();
      default:
        return draw_facts();
    }
  }

  SceneFacts draw_facts() {
    SceneFacts facts;
    const auto point = [&] { return SceneFacts::Point{rate(), -rate(), rate()}; };
    facts.given_hash = bits();
    facts.lowest_m = point();
    facts.highest_m = point();
    facts.point_count = bits32() % (SceneFacts::kMostPoints + 1);
    for (std::size_t i = 0; i < facts.point_count; ++i) facts.points_m[i] = point();
    return facts;
  }

  ReportPart draw_part() {
    ReportPart part;
    part.document = flag() ? ReportDocument::csv : ReportDocument::json;
    part.revision = bits32();
    part.part = bits32() % 100;
    part.parts = part.part + 1 + bits32() % 5;
    part.size = static_cast<std::uint16_t>(bits() % (part.text.size() + 1));
    std::fill_n(part.text.begin(), part.size, static_cast<char>(bits()));
    return part;
  }

  DeviceState draw_state(std::int64_t time) {
    DeviceState state{bits(), time, vector(), rotation(), bits32()};
    state.is_resumed = flag();
    if (state.is_resumed) state.p_WP = vector();
    return state;
  }

  HapticsSetup draw_setup() {
    HapticsSetup setup{bits32(),          bits32(),       draw_view().X_WS, bits(), {"scenes/car front.toml"},
                       {"0.1.0 release"}, {"name=proxy"}, bits32()};
    if (flag()) std::fill(setup.scene.begin(), setup.scene.end() - 1, 's');
    setup.scene_loading = bits32();
    if (flag()) std::fill(setup.refusal.begin(), setup.refusal.end() - 1, 'r');
    return setup;
  }

  ViewTransform draw_view() {
    ViewTransform view;
    view.revision = bits32();
    const Mat3 R = rotation().toRotationMatrix();
    const Vec3 t = vector();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        view.X_WS[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(column < 3 ? R(row, column) : t[row]);
      }
    }
    return view;
  }

  std::mt19937_64 random_;
};

constexpr std::size_t kKinds = std::variant_size_v<Message>;

void expect_equal(const Hello& a, const Hello& b) { EXPECT_EQ(a.role, b.role); }
void expect_equal(const Welcome& a, const Welcome& b) {
  EXPECT_EQ(a.accepted, b.accepted);
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
}
void expect_equal(const Bye&, const Bye&) {}
void expect_equal(const DeviceState& a, const DeviceState& b) {
  EXPECT_EQ(a.sample, b.sample);
  EXPECT_EQ(a.sample_time_ns, b.sample_time_ns);
  EXPECT_EQ(a.p_WD, b.p_WD);
  EXPECT_EQ(a.q_WT.coeffs(), b.q_WT.coeffs());
  EXPECT_EQ(a.buttons, b.buttons);
  EXPECT_EQ(a.is_resumed, b.is_resumed);
  EXPECT_EQ(a.p_WP, b.p_WP);
}
void expect_equal(const ForceCommand& a, const ForceCommand& b) {
  EXPECT_EQ(a.echo_sample, b.echo_sample);
  EXPECT_EQ(a.echo_sample_time_ns, b.echo_sample_time_ns);
  EXPECT_EQ(a.force_n, b.force_n);
  EXPECT_EQ(a.visual_offset_m, b.visual_offset_m);
  EXPECT_EQ(a.contact, b.contact);
  EXPECT_EQ(a.compute_ns, b.compute_ns);
  EXPECT_EQ(a.skipped_samples, b.skipped_samples);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.method_serial, b.method_serial);
  EXPECT_EQ(a.answered_before, b.answered_before);
}
void expect_equal(const ViewTransform& a, const ViewTransform& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.X_WS, b.X_WS);
}
void expect_equal(const ProbeState& a, const ProbeState& b) {
  EXPECT_EQ(a.sample, b.sample);
  EXPECT_EQ(a.sample_time_ns, b.sample_time_ns);
  EXPECT_EQ(a.p_WD, b.p_WD);
  EXPECT_EQ(a.q_WT.coeffs(), b.q_WT.coeffs());
  EXPECT_EQ(a.visual_offset_m, b.visual_offset_m);
  EXPECT_EQ(a.force_n, b.force_n);
  EXPECT_EQ(a.contact, b.contact);
  EXPECT_EQ(a.buttons, b.buttons);
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
  EXPECT_EQ(a.round_trip_p50_us, b.round_trip_p50_us);
  EXPECT_EQ(a.round_trip_p99_us, b.round_trip_p99_us);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.status, b.status);
}
void expect_equal(const Drawn& a, const Drawn& b) {
  EXPECT_EQ(a.echo_sample, b.echo_sample);
  EXPECT_EQ(a.echo_sample_time_ns, b.echo_sample_time_ns);
  EXPECT_EQ(a.frame_rate_hz, b.frame_rate_hz);
  EXPECT_EQ(a.held_ns, b.held_ns);
  EXPECT_EQ(a.rest_ns, b.rest_ns);
  EXPECT_EQ(a.unchanged, b.unchanged);
}
void expect_equal(const HandTarget& a, const HandTarget& b) {
  EXPECT_EQ(a.active, b.active);
  EXPECT_EQ(a.p_WH, b.p_WH);
}
void expect_equal(const Settings& a, const Settings& b) {
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.report_now, b.report_now);
  EXPECT_EQ(a.reset_faults, b.reset_faults);
  EXPECT_EQ(a.method_ask, b.method_ask);
}
void expect_equal(const HapticsSetup& a, const HapticsSetup& b) {
  EXPECT_EQ(a.method_serial, b.method_serial);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.X_WS, b.X_WS);
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(a.scene, b.scene);
  EXPECT_EQ(a.build, b.build);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.method_ask, b.method_ask);
  EXPECT_EQ(a.refusal, b.refusal);
  EXPECT_EQ(a.scene_loading, b.scene_loading);
}

void expect_equal(const ReportAsk& a, const ReportAsk& b) {
  EXPECT_EQ(a.document, b.document);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.part, b.part);
}
void expect_equal(const ReportPart& a, const ReportPart& b) {
  EXPECT_EQ(a.document, b.document);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.parts, b.parts);
  EXPECT_EQ(std::string_view(a.text.data(), a.size), std::string_view(b.text.data(), b.size));
}

void expect_equal(const SceneFacts& a, const SceneFacts& b) {
  EXPECT_EQ(a.given_hash, b.given_hash);
  EXPECT_EQ(a.lowest_m, b.lowest_m);
  EXPECT_EQ(a.highest_m, b.highest_m);
  EXPECT_EQ(a.point_count, b.point_count);
  EXPECT_EQ(a.points_m, b.points_m);
}

void expect_equal(const Datagram& a, const Datagram& b) {
  EXPECT_EQ(a.header.session, b.header.session);
  EXPECT_EQ(a.header.sender, b.header.sender);
  EXPECT_EQ(a.header.sequence, b.header.sequence);
  EXPECT_EQ(a.header.send_time_ns, b.header.send_time_ns);
  ASSERT_EQ(a.message.index(), b.message.index());
  std::visit([&](const auto& m) { expect_equal(m, std::get<std::decay_t<decltype(m)>>(b.message)); }, a.message);
}

// Whatever decode lets through must keep the contract's promises.
void expect_sane(const Datagram& datagram) {
  if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
    EXPECT_TRUE(state->p_WD.allFinite());
    EXPECT_NEAR(state->q_WT.norm(), 1.0, 1e-3);
  } else if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) {
    EXPECT_TRUE(force->force_n.allFinite());
    EXPECT_LE(force->force_n.cwiseAbs().maxCoeff(), kMaxWireMagnitude);
    EXPECT_TRUE(force->visual_offset_m.allFinite());
  } else if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
    EXPECT_TRUE(probe->p_WD.allFinite() && probe->force_n.allFinite() && probe->visual_offset_m.allFinite());
    EXPECT_TRUE(std::isfinite(probe->servo_rate_hz));
  } else if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) {
    for (const float value : view->X_WS) {
      EXPECT_TRUE(std::isfinite(value));
    }
  } else if (const auto* hello = std::get_if<Hello>(&datagram.message)) {
    EXPECT_GE(static_cast<int>(hello->role), 1);
    EXPECT_LE(static_cast<int>(hello->role), 4);
  } else if (const auto* settings = std::get_if<Settings>(&datagram.message)) {
    EXPECT_TRUE(settings->servo_rate_hz == 0.0 ||
                (settings->servo_rate_hz >= kMinServoRateHz && settings->servo_rate_hz <= kMaxServoRateHz));
  } else if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) {
    for (const HapticsSetup::Text& text : {setup->scene, setup->build, setup->method, setup->refusal}) {
      EXPECT_EQ(text.back(), '\0');
      EXPECT_TRUE(std::none_of(text.begin(), text.end(), [](char c) { return (c > 0 && c < ' ') || c == '\x7f'; }));
    }
  } else if (const auto* facts = std::get_if<SceneFacts>(&datagram.message)) {
    EXPECT_LE(facts->point_count, facts->points_m.size());
    for (const SceneFacts::Point& point : facts->points_m) {
      for (const float value : point) EXPECT_LE(std::abs(value), static_cast<float>(kMaxWireMagnitude));
    }
  } else if (const auto* part = std::get_if<ReportPart>(&datagram.message)) {
    EXPECT_LE(part->size, part->text.size());
    EXPECT_LT(part->part, part->parts);
  }
}

class CodecTest : public testing::Test {
 protected:
  Bytes encode(const Datagram& datagram) {
    Bytes bytes(kMaxDatagramBytes);
    bytes.resize(codec_.encode(datagram, bytes));
    return bytes;
  }

  DecodeStatus decode(const Bytes& bytes) { return codec_.decode(bytes, decoded_); }

  template <class M>
  DecodeStatus round_trip(const M& message) {
    return decode(encode(Datagram{{1, 2, 3, 4}, message}));
  }

  Codec codec_;
  Datagram decoded_;
  RandomDatagrams random_{kSeed};
};

TEST_F(CodecTest, RoundTripsEveryMessage) {
  for (int repeat = 0; repeat < 500; ++repeat) {
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const Datagram sent = random_.draw(kind);
      ASSERT_EQ(sent.message.index(), kind);
      const Bytes bytes = encode(sent);
      ASSERT_GT(bytes.size(), 0U);
      ASSERT_EQ(decode(bytes), DecodeStatus::ok) << "kind " << kind;
      expect_equal(sent, decoded_);
    }
  }
}

TEST_F(CodecTest, KeepsWithinTheByteBudget) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    // A setup, once a second, carries texts; so does a part of a report, when a tool asks for it.
    const std::size_t most = kind == 10 ? 900U : kind == 12 ? 1000U : 300U;
    EXPECT_LE(encode(random_.draw(kind)).size(), most) << "kind " << kind;
  }
}

// Who listens must not learn by lengths whether something is touched, or what it feels like.
TEST_F(CodecTest, WhatTheHandFeelsHasOneLengthWhateverItSays) {
  const Vec3 odd(-1.0 / 3.0, 1e8 / 3.0, -1e-8 / 3.0);
  const std::vector<std::vector<Message>> kinds = {
      {DeviceState{}, DeviceState{~std::uint64_t{0}, -1, odd, Quat(0.5, -0.5, 0.5, -0.5), ~0U},
       DeviceState{.sample = 1, .is_resumed = true, .p_WP = odd}},
      {ForceCommand{}, ForceCommand{.contact = true}, ForceCommand{.force_n = odd, .visual_offset_m = odd, .contact = true},
       ForceCommand{~std::uint64_t{0}, -1, odd, odd, true, ~0U, ~0U, ~0U, ~0U, ~std::uint64_t{0}}},
      {ProbeState{}, ProbeState{~std::uint64_t{0}, -1, odd, Quat(0.5, -0.5, 0.5, -0.5), odd, odd, true, ~0U, 1e9F, 1e9F, 1e9F, ~0U}}};
  for (const auto& messages : kinds) {
    std::set<std::size_t> lengths;
    for (const Message& message : messages) {
      for (const Header& header : {Header{}, Header{~std::uint64_t{0}, ~std::uint64_t{0}, ~std::uint64_t{0}, -1}}) {
        const Bytes bytes = encode({header, message});
        lengths.insert(bytes.size());
        EXPECT_EQ(decode(bytes), DecodeStatus::ok);
      }
    }
    EXPECT_EQ(lengths.size(), 1U) << "kind " << messages.front().index();
    EXPECT_GT(*lengths.begin(), 100U);
  }
}

TEST_F(CodecTest, RoundTripsDefaults) {
  EXPECT_EQ(round_trip(Hello{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Welcome{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(DeviceState{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ForceCommand{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ViewTransform{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ProbeState{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(HandTarget{}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(Settings{}), DecodeStatus::ok);
}

TEST_F(CodecTest, CarriesTheVersionFirst) {
  const Bytes bytes = encode(random_.draw(3));
  EXPECT_EQ(bytes[0], std::byte{0x08});
  EXPECT_EQ(bytes[1], std::byte{kProtocolVersion});
}

TEST_F(CodecTest, RefusesABufferThatIsTooSmall) {
  const Datagram datagram = random_.draw(3);
  const std::size_t size = encode(datagram).size();
  Bytes exact(size, std::byte{0});
  Bytes small(size - 1, std::byte{0xEE});
  EXPECT_EQ(codec_.encode(datagram, exact), size);
  EXPECT_EQ(codec_.encode(datagram, small), 0U);
  EXPECT_EQ(codec_.encode(datagram, {}), 0U);
  EXPECT_EQ(small, Bytes(size - 1, std::byte{0xEE}));
}

TEST_F(CodecTest, NoTruncationPasses) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Bytes bytes = encode(random_.draw(kind));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      // A copy of its own size, so that the address sanitizer sees a read past the end.
      const DecodeStatus status = decode(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
      EXPECT_TRUE(status == DecodeStatus::truncated || status == DecodeStatus::unknown_message)
          << "kind " << kind << " cut to " << size << ": " << to_string(status);
    }
  }
}

TEST_F(CodecTest, NoCorruptedByteCrashesOrBreaksThePromises) {
  std::size_t refused = 0;
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Bytes bytes = encode(random_.draw(kind));
    for (std::size_t place = 0; place < bytes.size(); ++place) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupted = bytes;
        corrupted[place] = static_cast<std::byte>(value);
        if (decode(corrupted) == DecodeStatus::ok) {
          expect_sane(decoded_);
        } else {
          ++refused;
        }
      }
    }
  }
  EXPECT_GT(refused, 1000U);
}

TEST_F(CodecTest, RandomBytesNeverCrash) {
  constexpr int kDatagrams = 300'000;
  for (int i = 0; i < kDatagrams; ++i) {
    Bytes bytes(random_.bits() % 200);
    for (std::byte& byte : bytes) {
      byte = static_cast<std::byte>(random_.bits());
    }
    if (i % 2 == 0 && bytes.size() > 2) {  // get past the version half of the time
      bytes[0] = std::byte{0x08};
      bytes[1] = std::byte{kProtocolVersion};
    }
    if (decode(bytes) == DecodeStatus::ok) {
      expect_sane(decoded_);
    }
  }
}

TEST_F(CodecTest, MutatedDatagramsNeverCrash) {
  for (int i = 0; i < 200'000; ++i) {
    Bytes bytes = encode(random_.draw(random_.bits() % kKinds));
    for (std::uint64_t mutation = 0; mutation < 1 + random_.bits() % 4; ++mutation) {
      const std::size_t place = 2 + random_.bits() % (bytes.size() - 2);
      switch (random_.bits() % 3) {
        case 0:
          bytes[place] = static_cast<std::byte>(random_.bits());
          break;
        case 1:
          bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(place));
          break;
        default:
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(place), static_cast<std::byte>(random_.bits()));
      }
    }
    if (decode(bytes) == DecodeStatus::ok) {
      expect_sane(decoded_);
    }
  }
}

TEST_F(CodecTest, LeavesTheDatagramAloneWhenItRefuses) {
  decoded_ = Datagram{{7, 8, 9, 10}, Welcome{true, 1234.0}};
  Bytes bytes = encode(random_.draw(3));
  bytes.resize(bytes.size() / 2);
  ASSERT_NE(decode(bytes), DecodeStatus::ok);
  expect_equal(decoded_, Datagram{{7, 8, 9, 10}, Welcome{true, 1234.0}});
}

TEST_F(CodecTest, TellsAnotherVersion) {
  Bytes bytes = encode(random_.draw(3));
  bytes[1] = std::byte{kProtocolVersion + 1};
  EXPECT_EQ(decode(bytes), DecodeStatus::wrong_version);
  // Whatever a later version puts behind its number.
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{kProtocolVersion + 1}, std::byte{0xFF}, std::byte{0xFF}}), DecodeStatus::wrong_version);
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{0x80}, std::byte{0x01}}), DecodeStatus::wrong_version);
  EXPECT_EQ(decode({std::byte{0x08}, std::byte{0x00}}), DecodeStatus::wrong_version);
}

TEST_F(CodecTest, TellsAnUnknownMessageAndSkipsUnknownFields) {
  // Field 100, length-delimited, two bytes: a message of a later build.
  const Bytes later = {std::byte{0xA2}, std::byte{0x06}, std::byte{0x02}, std::byte{0x08}, std::byte{0x01}};
  Bytes unknown = {std::byte{0x08}, std::byte{kProtocolVersion}};
  unknown.insert(unknown.end(), later.begin(), later.end());
  EXPECT_EQ(decode(unknown), DecodeStatus::unknown_message);

  const Datagram sent = random_.draw(3);
  Bytes extended = encode(sent);
  extended.insert(extended.end(), later.begin(), later.end());
  ASSERT_EQ(decode(extended), DecodeStatus::ok);
  expect_equal(sent, decoded_);
}

TEST_F(CodecTest, RefusesTwoMessagesInOne) {
  Bytes both = encode(Datagram{{}, Hello{}});
  const Bytes drawn = encode(Datagram{{}, Drawn{1, 2, 3.0F}});
  both.insert(both.end(), drawn.begin(), drawn.end());
  EXPECT_EQ(decode(both), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RefusesAVectorOfTheWrongLength) {
  // Concatenating the same message merges its repeated fields: six numbers where three belong.
  Bytes doubled = encode(random_.draw(3));
  const Bytes once = doubled;
  doubled.insert(doubled.end(), once.begin(), once.end());
  EXPECT_EQ(decode(doubled), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RefusesValuesOutsideTheContract) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity, 2 * kMaxWireMagnitude}) {
    EXPECT_EQ(round_trip(DeviceState{.p_WD = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(1, 0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(DeviceState{.is_resumed = true, .p_WP = Vec3(0, bad, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.force_n = Vec3(0, 0, bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ForceCommand{.visual_offset_m = Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.visual_offset_m = Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(ProbeState{.round_trip_p99_us = static_cast<float>(bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(HandTarget{true, Vec3(bad, 0, 0)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(Welcome{true, bad}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(Drawn{1, 2, static_cast<float>(bad)}), DecodeStatus::bad_value);
    EXPECT_EQ(round_trip(Settings{.servo_rate_hz = bad}), DecodeStatus::bad_value);
    for (const std::size_t place : {0U, 3U, 11U}) {
      ViewTransform view;
      view.X_WS[place] = static_cast<float>(bad);
      EXPECT_EQ(round_trip(view), DecodeStatus::bad_value) << place;
    }
  }
  EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(0, 0, 0, 0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(DeviceState{.q_WT = Quat(1.01, 0, 0, 0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ViewTransform{.X_WS = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0}}), DecodeStatus::bad_value);  // a mirror
  EXPECT_EQ(round_trip(ViewTransform{.X_WS = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}}), DecodeStatus::bad_value);   // a scale
  EXPECT_EQ(round_trip(Hello{static_cast<NodeRole>(0)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Hello{static_cast<NodeRole>(5)}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.servo_rate_hz = 100.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.servo_rate_hz = 20'000.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Settings{.method = {'a', '\n'}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(HapticsSetup{.refusal = {'a', '\n'}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(HapticsSetup{.refusal = {'\x1b', '['}}), DecodeStatus::bad_value);
  HapticsSetup endless;
  endless.refusal.fill('x');  // the last place is NUL
  EXPECT_EQ(round_trip(endless), DecodeStatus::bad_value);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(round_trip(SceneFacts{.lowest_m = {0, kNan, 0}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(SceneFacts{.point_count = 1, .points_m = {{{0, 0, 2e9F}}}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(Drawn{1, 2, -1.0F}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ReportPart{.part = 2, .parts = 2}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ReportAsk{.document = static_cast<ReportDocument>(2)}), DecodeStatus::bad_value);
}

TEST_F(CodecTest, RefusesMoreThanADatagramHolds) {
  EXPECT_EQ(decode(Bytes(kMaxDatagramBytes + 1, std::byte{0x08})), DecodeStatus::bad_value);
}

// The compiler may drop a new-expression it can see through, but not this call.
TEST(AllocationGuardTest, SeesAnAllocation) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  const AllocationGuard guard;
  void* memory = ::operator new(32);
  EXPECT_EQ(guard.count(), 1U);
  ::operator delete(memory);
  EXPECT_EQ(guard.count(), 1U);
}

TEST_F(CodecTest, NeverUsesTheHeap) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  std::array<std::byte, kMaxDatagramBytes> buffer = {};
  const AllocationGuard guard;
  for (int repeat = 0; repeat < 50; ++repeat) {
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const Datagram sent = random_.draw(kind);
      const std::size_t size = codec_.encode(sent, buffer);
      codec_.decode(std::span(buffer).first(size), decoded_);
    }
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(CodecTest, AFalseLengthReservesNothing) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  // A ProbeState that claims 200 MB, and in it an unknown field that claims 100 MB.
  const Bytes bytes = {std::byte{0x08}, std::byte{kProtocolVersion},
                       std::byte{0xB2}, std::byte{0x01},
                       std::byte{0x80}, std::byte{0x84},
                       std::byte{0xAF}, std::byte{0x5F},
                       std::byte{0xA2}, std::byte{0x06},
                       std::byte{0x80}, std::byte{0xC2},
                       std::byte{0xD7}, std::byte{0x2F},
                       std::byte{0x00}, std::byte{0x00}};
  const AllocationGuard guard;
  EXPECT_EQ(decode(bytes), DecodeStatus::truncated);
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(CodecTest, HostileBytesDoNotReachTheHeapEither) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  std::array<std::byte, kMaxDatagramBytes> buffer = {};
  const AllocationGuard guard;
  for (int i = 0; i < 100'000; ++i) {
    const std::size_t size = codec_.encode(random_.draw(random_.bits() % kKinds), buffer);
    // Corrupt some bytes and let rubbish follow, up to a full datagram.
    std::size_t length = size;
    while (length + 8 <= buffer.size() && random_.bits() % 64 != 0) {
      const std::uint64_t rubbish = random_.bits();
      std::memcpy(buffer.data() + length, &rubbish, sizeof rubbish);
      length += sizeof rubbish;
    }
    buffer[2 + random_.bits() % (length - 2)] = static_cast<std::byte>(random_.bits());
    codec_.decode(std::span(buffer).first(length), decoded_);
  }
  // Well-formed floods: every field of every message that can grow, filled with one whole datagram.
  for (int message = 16; message < 29; ++message) {
    for (int field = 1; field < 16; ++field) {
      for (const int wire_type : {0, 1, 2, 3, 5}) {
        std::size_t length = 0;
        const auto put = [&](int value) { buffer[length++] = static_cast<std::byte>(value); };
        put(0x08);
        put(static_cast<int>(kProtocolVersion));
        put(0x80 | ((message << 3 | 2) & 0x7F));
        put((message << 3 | 2) >> 7);
        constexpr int kBody = 1190;
        put(0x80 | (kBody & 0x7F));
        put(kBody >> 7);
        const std::size_t end = length + kBody;
        const std::size_t start = length;
        if (wire_type == 2) {
          constexpr int kPayload = 1184;
          put(field << 3 | 2);
          put(0x80 | (kPayload & 0x7F));
          put(kPayload >> 7);
        }
        while (length < end) {
          buffer[length] = wire_type == 2 || (length - start) % 9 != 0 ? std::byte{0} : static_cast<std::byte>(field << 3 | wire_type);
          ++length;
        }
        codec_.decode(std::span(buffer).first(length), decoded_);
      }
    }
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
