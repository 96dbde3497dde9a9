#include "link/asio_guard.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "link/metrics_endpoint.h"
#include "link/relay_endpoint.h"
#include "link/udp_endpoint.h"
#include "link/websocket_endpoint.h"

namespace hapton {
namespace {

// Uses all descriptors that this process may have, except a given number.
class NoDescriptors {
 public:
  explicit NoDescriptors(std::size_t left) {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit few = {.rlim_cur = std::min<rlim_t>(before_.rlim_cur, 64), .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &few);
    for (int file = open("/dev/null", O_RDONLY | O_CLOEXEC); file >= 0; file = open("/dev/null", O_RDONLY | O_CLOEXEC)) {
      taken_.push_back(file);
    }
    for (; left > 0 && !taken_.empty(); --left, taken_.pop_back()) close(taken_.back());
  }
  ~NoDescriptors() {
    for (const int file : taken_) close(file);
    setrlimit(RLIMIT_NOFILE, &before_);
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;

 private:
  rlimit before_ = {};
  std::vector<int> taken_;
};

class AsioGuardTest : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "sanitizers need descriptors of their own to look at an exception";
#endif
  }
};

template <class Try>
void expect_one_line(Try&& attempt) {
  for (std::size_t left = 0; left < 6; ++left) {
    std::string message;
    {
      const NoDescriptors none(left);
      const auto result = attempt();
      if (!result) message = result.error().what;
    }
    EXPECT_TRUE(left > 0 || !message.empty());
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

TEST_F(AsioGuardTest, NoEndpointThrowsWhereDescriptorsAreUsedUp) {
  expect_one_line([] { return open_udp_endpoint("127.0.0.1:0"); });
  expect_one_line([] { return MetricsEndpoint::open("127.0.0.1:0"); });
  expect_one_line([] {
    RelaySettings settings;
    settings.hub = *parse_address("127.0.0.1:9");
    return RelayEndpoint::open(settings);
  });
  expect_one_line([] { return WebSocketEndpoint::connect(*parse_address("127.0.0.1:9"), 1'000'000); });
}

TEST_F(AsioGuardTest, ANameIsAnErrorWhereDescriptorsAreUsedUp) {
  expect_one_line([] { return parse_address("no.such.host.invalid:1"); });
}

TEST_F(AsioGuardTest, MakesTheRequestedEndpoint) {
  const auto made = make_with_context<std::pair<int, int>>(1, 2);
  ASSERT_TRUE(made);
  EXPECT_EQ((*made)->second, 2);
}

}  // namespace
}  // namespace hapton
