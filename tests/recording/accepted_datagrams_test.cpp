#include "recording/accepted_datagrams.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "recording/cycle_table.h"
#include "recording/recording_index.h"
#include "recording/recording_rows.h"
#include "tests/recording/made_recording.h"

namespace hapton {
namespace {

using Kind = SessionEntry::Kind;

const Address kFirstNode = {{}, 5001};
const Address kSecondNode = {{}, 5002};
const Address kVision = {{}, 5003};

struct AcceptedDatagramsTest : testing::Test {
  bool accepts_received(const Address& from, const Message& message, std::uint64_t session = 7) {
    return accept(Kind::received, from, message, session);
  }
  bool accepts_sent(const Address& to, const Message& message) { return accept(Kind::sent, to, message, 7); }
  bool accept(Kind kind, const Address& peer, const Message& message, std::uint64_t session) {
    SessionEntry entry;
    entry.kind = kind;
    entry.peer = peer;
    return accepted.accept(entry, Datagram{{.session = session}, message});
  }

  AcceptedDatagrams accepted{7};
};

TEST_F(AcceptedDatagramsTest, NotThoseOfAnEarlierSessionOfTheHub) {
  EXPECT_FALSE(accepts_received(kFirstNode, ForceCommand{}, 6));
  EXPECT_FALSE(accepts_received(kFirstNode, ViewTransform{}, 6));
  EXPECT_TRUE(accepts_received(kFirstNode, Hello{NodeRole::haptics}, 0)) << "of no session yet";
  EXPECT_TRUE(accepts_received(kFirstNode, ForceCommand{}));
  accepted = AcceptedDatagrams(0);
  EXPECT_TRUE(accepts_received(kFirstNode, ForceCommand{})) << "the recording does not say which it is";
}

TEST_F(AcceptedDatagramsTest, ForcesOfTheHapticsNodeThatGetsTheStates) {
  EXPECT_TRUE(accepts_received(kFirstNode, ForceCommand{})) << "not known yet which it is";
  EXPECT_TRUE(accepts_sent(kFirstNode, DeviceState{}));
  EXPECT_TRUE(accepts_received(kFirstNode, ForceCommand{}));
  EXPECT_FALSE(accepts_received(kSecondNode, ForceCommand{}));
  EXPECT_FALSE(accepts_received(kSecondNode, HapticsSetup{}));
  EXPECT_TRUE(accepts_received(kSecondNode, ViewTransform{})) << "of a vision node";
  EXPECT_TRUE(accepts_sent(kSecondNode, DeviceState{}));
  EXPECT_FALSE(accepts_received(kFirstNode, ForceCommand{})) << "another one has its place";
}

TEST_F(AcceptedDatagramsTest, ASecondHapticsNodeCountsOnceTheHubHasAcceptedIt) {
  accepts_sent(kFirstNode, DeviceState{});
  accepts_received(kSecondNode, Hello{NodeRole::haptics});
  accepts_sent(kSecondNode, Welcome{.accepted = false});
  EXPECT_FALSE(accepts_received(kSecondNode, HapticsSetup{}));
  accepts_received(kVision, Hello{NodeRole::vision});
  accepts_sent(kVision, Welcome{.accepted = true});
  EXPECT_FALSE(accepts_received(kVision, HapticsSetup{}));
  accepts_received(kSecondNode, Hello{NodeRole::vision});
  accepts_sent(kSecondNode, Welcome{.accepted = true});
  EXPECT_FALSE(accepts_received(kSecondNode, HapticsSetup{})) << "another program at that address";
  EXPECT_TRUE(accepts_received(kFirstNode, HapticsSetup{}));
  accepts_received(kSecondNode, Hello{NodeRole::haptics});
  accepts_sent(kSecondNode, Welcome{.accepted = true});
  EXPECT_TRUE(accepts_received(kSecondNode, HapticsSetup{}));
  EXPECT_FALSE(accepts_received(kFirstNode, HapticsSetup{}));
}

// Sample numbers begin anew with each session of the hub: the force was for the sample of this number in the earlier session.
TEST(AcceptedDatagramsOfARecording, AForceOfAnEarlierSessionIsInNoTable) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample != 1000) return;
    recording.session = 5;
    recording.receive(MadeRecording::kHaptics, force_of(1001), sample);
    recording.receive(MadeRecording::kHaptics, HapticsSetup{.method_serial = 9}, sample);
    recording.session = MadeRecording::kSession;
  };
  const auto file = recording.write(scratch);
  auto reader = SessionReader::open(file);
  ASSERT_TRUE(reader) << reader.error().what;
  std::map<std::uint64_t, double> wanted_n;
  CycleTable table(reader->header().start_ns, [&](const CycleRow& row) { wanted_n[row.sample] = row.wanted_n.z(); });
  table.add_all(*reader);
  EXPECT_TRUE(std::isnan(wanted_n.at(1001)));
  EXPECT_EQ(wanted_n.at(1002), 1002.0);
  auto again = SessionReader::open(file);
  ASSERT_TRUE(again);
  const auto index = RecordingIndex::read(*again);
  ASSERT_TRUE(index) << index.error().what;
  EXPECT_EQ(index->find_setup(3.0)->method_serial, 1U);
  auto rows = RecordingRows::open(file, *index);
  ASSERT_TRUE(rows);
  const CycleRow* row = rows->at(1.0015);
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->sample, 1001U);
  EXPECT_TRUE(std::isnan(row->wanted_n.z()));
}

}  // namespace
}  // namespace hapton
