#include "tools/live/marker_line.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr std::int64_t kLineMs = 1'000'000;

std::string text_of(const Marker& marker) { return marker.text.data(); }

TEST(LineInputs, AreADeviceAndAnInput) {
  const auto input = parse_line_input("/dev/serial/by-id/a:b:DSR");
  ASSERT_TRUE(input);
  EXPECT_EQ(input->device, "/dev/serial/by-id/a:b");
  EXPECT_EQ(input->name, "DSR");
  for (const char* bad : {"", ":", "CTS", ":CTS", "/dev/ttyS0", "/dev/ttyS0:", "/dev/ttyS0:cts", "/dev/ttyS0:RTS", "/dev/ttyS0:CTS "}) {
    EXPECT_FALSE(parse_line_input(bad)) << bad;
  }
}

TEST(LineInputs, WhatIsNoSerialPortIsRejected) {
  const ScratchFolder scratch;
  const std::string file = scratch.write("file", "text").string();
  EXPECT_FALSE(open_line_input(*parse_line_input(file + ":CTS")));
  EXPECT_FALSE(open_line_input(*parse_line_input((scratch.path() / "none").string() + ":CTS")));
  // A terminal without modem lines.
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(::grantpt(terminal), 0);
  ASSERT_EQ(::unlockpt(terminal), 0);
  const auto opened = open_line_input(*parse_line_input(std::string(::ptsname(terminal)) + ":CTS"));
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("not a serial port with a CTS input"), std::string::npos) << opened.error().what;
  ::close(terminal);
}

TEST(LineInputs, OfAParallelPortAreKnownByTheirNames) {
  const auto input = parse_line_input("/dev/parport0:BUSY");
  ASSERT_TRUE(input);
  EXPECT_TRUE(input->is_parallel);
  EXPECT_EQ(input->device, "/dev/parport0");
  EXPECT_FALSE(parse_line_input("/dev/ttyS0:CTS")->is_parallel);
  for (const char* bad : {"/dev/parport0", "/dev/parport0:D0", "/dev/parport0:ack"}) EXPECT_FALSE(parse_line_input(bad)) << bad;
}

// The status byte of a port with nothing on it is 0x7f: all inputs are pulled up, and the hardware inverts BUSY (IEEE 1284).
TEST(LineInputs, OfAParallelPortAreHighWhereTheirPinIs) {
  const std::pair<const char*, unsigned char> pins[] = {{"ACK", 0x40}, {"PAPEROUT", 0x20}, {"SELECT", 0x10}, {"ERROR", 0x08}};
  for (const auto& [name, bit] : pins) {
    const LineInput input = *parse_line_input(std::string("/dev/parport0:") + name);
    EXPECT_TRUE(is_high(input, 0x7f)) << name;
    EXPECT_FALSE(is_high(input, static_cast<unsigned char>(0x7f & ~bit))) << name;
  }
  const LineInput busy = *parse_line_input("/dev/parport0:BUSY");
  EXPECT_TRUE(is_high(busy, 0x7f));
  EXPECT_FALSE(is_high(busy, 0xff));
}

TEST(LineInputs, WhatIsNoParallelPortIsRejected) {
  const ScratchFolder scratch;
  const std::string file = scratch.write("file", "text").string();
  const auto opened = open_line_input(*parse_line_input(file + ":ACK"));
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("is not a parallel port"), std::string::npos) << opened.error().what;
  const auto missing = open_line_input(*parse_line_input((scratch.path() / "parport9").string() + ":ACK"));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().what.find("modprobe ppdev"), std::string::npos) << missing.error().what;
}

TEST(LineMarkers, EachChangeThatCountsIsOneMarker) {
  struct Case {
    Edges edges;
    std::vector<std::string> texts;
  };
  for (const Case& one : {Case{Edges::on, {"up", "up"}}, Case{Edges::off, {"down"}}, Case{Edges::both, {"up", "down", "up"}}}) {
    LineMarker line(one.edges, "up", "down");
    std::vector<std::string> texts;
    std::int64_t now = 0;
    for (const bool is_on : {false, false, true, true, true, false, false, true}) {
      line.observe(is_on, now += kLineMs);
      while (const auto marker = line.next(now)) texts.push_back(text_of(*marker));
    }
    EXPECT_EQ(texts, one.texts);
    EXPECT_EQ(line.counts().changes, 3U);
  }
}

TEST(LineMarkers, ALineThatIsOnAtTheStartMarksNothing) {
  LineMarker line(Edges::both, "up", "down");
  for (int i = 0; i < 10; ++i) line.observe(true, i);
  EXPECT_FALSE(line.next(20));
  line.observe(false, 30);
  EXPECT_EQ(text_of(*line.next(30)), "down");
}

TEST(LineMarkers, AMarkerIsRepeatedUntilItsReply) {
  LineMarker line(Edges::on, "up", "down");
  line.observe(false, 0);
  line.observe(true, 0);
  const auto first = line.next(0);
  ASSERT_TRUE(first);
  EXPECT_FALSE(line.next(LineMarker::kRepeatNs - 1));
  const auto again = line.next(LineMarker::kRepeatNs);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->request, first->request);
  EXPECT_FALSE(line.take({.request = first->request + 1, .sample = 5}));
  EXPECT_EQ(*line.take({.request = first->request, .sample = 5}), "marked sample 5: up");
  EXPECT_FALSE(line.take({.request = first->request, .sample = 5})) << "only once";
  EXPECT_FALSE(line.next(10 * LineMarker::kRepeatNs));
  EXPECT_EQ(line.counts().marked, 1U);
}

TEST(LineMarkers, ARejectionIsReportedAndCounted) {
  LineMarker line(Edges::on, "up", "down");
  line.observe(false, 0);
  line.observe(true, 0);
  const auto report = line.take({.request = line.next(0)->request, .status = MarkerStatus::no_recording});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->find("not marked: up: "), 0U) << *report;
  EXPECT_EQ(line.counts().rejected, 1U);
  EXPECT_EQ(line.counts().marked, 0U);
}

TEST(LineMarkers, WithoutAHubTheyAreGivenUp) {
  LineMarker line(Edges::both, "up", "down");
  for (int i = 0; i < 100; ++i) line.observe(i % 2 == 1, i * kLineMs);
  int markers_sent = 0;
  while (line.next(100 * kLineMs)) ++markers_sent;
  EXPECT_EQ(markers_sent, static_cast<int>(LineMarker::kMaxPending));
  EXPECT_FALSE(line.next(100 * kLineMs + LineMarker::kReplyTimeoutNs));
  EXPECT_FALSE(line.has_pending());
  EXPECT_EQ(line.counts().given_up, 99U);
}

// Whatever is lost on the way: each change is marked, rejected or given up, exactly once.
TEST(LineMarkers, NoChangeIsCountedTwice) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937_64 random(seed);
    LineMarker line(Edges::both, "up", "down");
    std::set<std::uint32_t> recorded;
    std::vector<MarkerReply> replies;
    bool is_on = false;
    std::int64_t now = 0;
    line.observe(is_on, now);
    for (int i = 0; i < 20'000; ++i) {
      now += kLineMs;
      if (random() % 40 == 0) line.observe(is_on = !is_on, now);
      while (const auto marker = line.next(now)) {
        if (random() % 3 == 0) continue;  // lost
        recorded.insert(marker->request);
        if (random() % 3 != 0) replies.push_back({.request = marker->request, .sample = 1});
      }
      if (random() % 5 == 0) {
        for (const MarkerReply& reply : replies) line.take(reply);
        replies.clear();
      }
    }
    const auto& counts = line.counts();
    EXPECT_LE(counts.marked + counts.rejected + counts.given_up, counts.changes) << seed;
    EXPECT_GE(counts.marked + counts.rejected + counts.given_up + LineMarker::kMaxPending, counts.changes) << seed;
    EXPECT_LE(counts.marked, recorded.size()) << seed;
    EXPECT_GT(counts.marked, 300U) << seed;
  }
}

// The texts are those that docs/sessions.md gives: experiments are evaluated by them.
TEST(LineMarkers, AreNamedByTheInputOrByTheTextThatIsGiven) {
  const LineInput input = *parse_line_input("/dev/ttyS0:CTS");
  const auto texts_of = [&](std::string_view edges, const std::string& text) {
    std::vector<std::string> texts;
    auto line = make_line_marker(input, edges, text);
    if (!line) return texts;
    std::int64_t now = 0;
    for (const bool is_on : {false, true, false}) {
      line->observe(is_on, now += kLineMs);
      while (const auto marker = line->next(now)) texts.push_back(text_of(*marker));
    }
    return texts;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(texts_of("on", ""), (Texts{"CTS on"}));
  EXPECT_EQ(texts_of("off", ""), (Texts{"CTS off"}));
  EXPECT_EQ(texts_of("both", ""), (Texts{"CTS on", "CTS off"}));
  EXPECT_EQ(texts_of("on", "pedal"), (Texts{"pedal"}));
  EXPECT_EQ(texts_of("off", "pedal"), (Texts{"pedal"}));
  EXPECT_EQ(texts_of("both", "pedal"), (Texts{"pedal on", "pedal off"}));
  const std::string longest(160, 'x');
  EXPECT_TRUE(make_line_marker(input, "on", longest));
  EXPECT_FALSE(make_line_marker(input, "both", longest)) << "no room for ' on' and ' off'";
}

}  // namespace
}  // namespace hapton
