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

// Leaves this process only the given number of free descriptors.
class FewDescriptors {
 public:
  explicit FewDescriptors(std::size_t left) {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit few = {.rlim_cur = std::min<rlim_t>(before_.rlim_cur, 64), .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &few);
    for (int file = open("/dev/null", O_RDONLY | O_CLOEXEC); file >= 0; file = open("/dev/null", O_RDONLY | O_CLOEXEC)) {
      files_.push_back(file);
    }
    for (; left > 0 && !files_.empty(); --left, files_.pop_back()) close(files_.back());
  }
  ~FewDescriptors() {
    for (const int file : files_) close(file);
    setrlimit(RLIMIT_NOFILE, &before_);
  }
  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors& operator=(const FewDescriptors&) = delete;

 private:
  rlimit before_ = {};
  std::vector<int> files_;
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
      const FewDescriptors few(left);
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

TEST_F(AsioGuardTest, AHostNameIsAnErrorWhereDescriptorsAreUsedUp) {
  expect_one_line([] { return parse_address("no.such.host.invalid:1"); });
}

TEST_F(AsioGuardTest, MakesTheRequestedObject) {
  const auto made = make_with_context<std::pair<int, int>>(1, 2);
  ASSERT_TRUE(made);
  EXPECT_EQ((*made)->second, 2);
}

}  // namespace
}  // namespace hapton
