// Mutators know seals, checksums and counts: their changes pass these checks, where plain changes do not, and still change something.
#include <gtest/gtest.h>

#include <set>

#include "tests/fuzz/corpus.h"
#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/handshake_line.h"
#include "tests/fuzz/proto_mutator.h"
#include "tests/fuzz/sealed_session.h"
#include "tests/fuzz/session_mutator.h"

namespace hapton::fuzz {
namespace {

constexpr std::uint64_t kSeed = 13;
constexpr std::size_t kMaxInputBytes = 4096;

// A stand-in for LLVMFuzzerMutate.
Mutation::ChangeBytes plain_changes(std::mt19937_64& random) {
  return [&random](std::uint8_t* data, std::size_t size, std::size_t most) {
    const Bytes changed = mutate({Bytes(data, data + size)}, random);
    const std::size_t size_left = std::min(changed.size(), most);
    std::copy_n(changed.begin(), size_left, data);
    return size_left;
  };
}

// The share of inputs that pass the check of the target.
template <class MakeInput>
double passing_share(const std::string& target, int inputs, MakeInput&& make_input) {
  passage() = {};
  for (int i = 0; i < inputs; ++i) run_counted(targets().at(target), make_input(static_cast<std::uint64_t>(i)));
  return static_cast<double>(passage().passed) / static_cast<double>(passage().inputs);
}

// Changes an input of the corpus several times in succession, as a fuzzer continues with an input that it has found.
Bytes change_of(const std::string& target, const std::vector<Bytes>& corpus, std::uint64_t number, std::uint64_t changes) {
  std::mt19937_64 random(kSeed + number);
  Bytes input = corpus[number % corpus.size()];
  for (std::uint64_t i = 0; i < changes; ++i) {
    Mutation mutation(random(), kMaxInputBytes, plain_changes(random));
    input = mutators().at(target)(input, mutation);
  }
  return input;
}

// The inputs of a corpus that pass the check unchanged.
std::vector<Bytes> find_passing(const std::string& target) {
  std::vector<Bytes> passing;
  for (const Bytes& input : read_corpus(target)) {
    if (passing_share(target, 1, [&](std::uint64_t) { return input; }) > 0.0) passing.push_back(input);
  }
  return passing;
}

struct Case {
  const char* target;
  double at_least;   // smallest share of the mutator's changes that pass
  double advantage;  // over plain changes, as a factor
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.target; }

class Mutator : public testing::TestWithParam<Case> {
 protected:
  static constexpr int kInputs = 600;
  const std::vector<Bytes> corpus_ = find_passing(GetParam().target);
};

// This fails when the protocol has changed and the corpus has not: see make_corpus.cpp.
TEST_P(Mutator, HasInputsThatPassTheCheck) {
  EXPECT_GE(corpus_.size(), 1U);
  if (GetParam().target == std::string("codec")) {
    EXPECT_EQ(corpus_.size(), read_corpus("codec").size());
  }
}

TEST_P(Mutator, PassesChecksThatStopPlainChanges) {
  const Case& c = GetParam();
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const double plain = passing_share(c.target, kInputs, [&](std::uint64_t) { return mutate(corpus_, random); });
  const double with_mutator = passing_share(c.target, kInputs, [&](std::uint64_t i) { return change_of(c.target, corpus_, i, 1 + i % 3); });
  RecordProperty("plain", std::to_string(plain));
  RecordProperty("knowing", std::to_string(with_mutator));
  EXPECT_GE(with_mutator, c.at_least);
  EXPECT_GE(with_mutator, c.advantage * plain);
}

TEST_P(Mutator, MakesManyDifferentInputs) {
  std::set<Bytes> different;
  for (std::uint64_t i = 0; i < 200; ++i) different.insert(change_of(GetParam().target, corpus_, i, 1));
  EXPECT_GE(different.size(), 120U);
}

TEST_P(Mutator, MakesTheSameInputFromTheSameSeed) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    EXPECT_EQ(change_of(GetParam().target, corpus_, i, 2), change_of(GetParam().target, corpus_, i, 2)) << i;
  }
}

TEST_P(Mutator, AcceptsBytesThatAreNoInput) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    std::mt19937_64 random(kSeed + i);
    Bytes junk(random() % 300);
    for (std::uint8_t& byte : junk) byte = static_cast<std::uint8_t>(random());
    targets().at(GetParam().target)(change_of(GetParam().target, {junk}, i, 3));
  }
  targets().at(GetParam().target)(change_of(GetParam().target, {Bytes()}, 0, 3));
}

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.target; }

INSTANTIATE_TEST_SUITE_P(Fuzz, Mutator,
                         testing::Values(Case{"sealed", 0.8, 4.0}, Case{"request", 0.8, 4.0}, Case{"session", 0.6, 4.0},
                                         Case{"stl", 0.5, 1.3}, Case{"glb", 0.4, 1.3}, Case{"codec", 0.3, 1.3}, Case{"patch", 0.3, 1.3}),
                         name_of);

TEST(Mutator, KnowsEveryTargetThatItIsTestedWith) {
  std::set<std::string> tested = {"sealed", "request", "session", "stl", "glb", "codec", "patch"};
  for (const auto& [name, mutate] : mutators()) EXPECT_EQ(tested.count(name), 1U) << name;
  EXPECT_EQ(mutators().size(), tested.size());
}

class Crossover : public testing::TestWithParam<std::string> {};

TEST_P(Crossover, MostlyPassesTheCheck) {
  const std::vector<Bytes> corpus = read_corpus(GetParam());
  const double share = passing_share(GetParam(), 300, [&](std::uint64_t i) {
    std::mt19937_64 random(kSeed + i);
    Mutation mutation(i, kMaxInputBytes, plain_changes(random));
    return crossovers().at(GetParam())(corpus[i % corpus.size()], corpus[random() % corpus.size()], mutation);
  });
  EXPECT_GE(share, 0.5);
}

std::string name_of_target(const testing::TestParamInfo<std::string>& target) { return target.param; }

INSTANTIATE_TEST_SUITE_P(Fuzz, Crossover, testing::Values("sealed", "request", "session", "patch"), name_of_target);

TEST(SealedMutator, SealsAsTheChannelDoes) {
  ASSERT_TRUE(FixedRandom::install());
  for (std::uint8_t node = 0; node < 4; ++node) {
    SealedChannel channel = make_channel(node, SealedChannel::Side::client);
    const Bytes word = {1, 2, 3};
    std::array<std::byte, 64> sealed;
    const std::size_t size = channel.seal(as_datagram(word), sealed);
    ListedDatagram datagram{.flags = static_cast<std::uint8_t>(node << 1), .bytes = Bytes(size)};
    std::copy_n(seal::bytes_of(std::span<std::byte>(sealed)), size, datagram.bytes.begin());
    const auto opened = open_data(datagram);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->payload, word);
    EXPECT_EQ(seal_data(*opened, datagram), datagram.bytes);
    datagram.flags ^= 1U;
    EXPECT_FALSE(open_data(datagram)) << "the other direction has another key";
  }
}

// Requests get replies, and replies open sessions: the mutator makes the cookie and the Noise message right, too.
TEST(HandshakeMutator, ReachesTheAgreementAndTheSession) {
  ASSERT_TRUE(FixedRandom::install());
  const std::vector<Bytes> corpus = read_corpus("request");
  int retries = 0;
  int replies = 0;
  int sessions = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    HandshakeLine line;
    for (const ListedDatagram& datagram : split_datagrams(change_of("request", corpus, i, 2))) {
      if (datagram.bytes.empty() || datagram.bytes.size() > kMaxDatagramBytes) continue;
      line.deliver(datagram);
    }
    for (const auto& sent : line.from_hub()) ++(find_handshake_kind(sent.bytes) == seal::Kind::reply ? replies : retries);
    sessions += static_cast<int>(line.node().seal_counts().handshakes);
  }
  EXPECT_GE(retries, 30);
  EXPECT_GE(replies, 100);
  EXPECT_GE(sessions, 15);
}

TEST(HandshakeMutator, KnowsTheCookieOfTheHub) {
  ASSERT_TRUE(FixedRandom::install());
  const std::int64_t now_ns = 1000 * kNanosecondsPerSecond;
  for (std::uint8_t node = 0; node < 4; ++node) {
    HandshakeLine line;
    const auto flags = static_cast<std::uint8_t>(node << 1);
    ListedDatagram request{.flags = flags, .bytes = {}};
    request.bytes = make_request(request.role(), 1, now_ns, find_cookie(node, now_ns));
    line.deliver(request);
    ASSERT_EQ(line.from_hub().size(), 1U);
    EXPECT_EQ(find_handshake_kind(line.from_hub()[0].bytes), seal::Kind::reply);
    EXPECT_TRUE(has_tag(line.from_hub()[0].bytes, request.role()));
  }
}

TEST(ProtoMutator, TakesApartAndPutsTogetherEveryMessage) {
  for (const Bytes& message : read_corpus("codec")) {
    const auto fields = split_proto(message);
    ASSERT_TRUE(fields);
    EXPECT_EQ(join_proto(*fields), message);
  }
}

TEST(SessionMutator, TakesApartAndPutsTogetherEveryRecording) {
  for (const Bytes& file : read_corpus("session")) {
    const auto messages = split_session(file);
    ASSERT_TRUE(messages);
    EXPECT_EQ(join_session(*messages), file);
  }
}

}  // namespace
}  // namespace hapton::fuzz
