// The direction in which `hapton relay` applies its faults.
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>

#include "link/udp_endpoint.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/text_bytes.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

// A node sends to a hub through the relay until a reply has come back; then the relay is ended by a signal.
void talk_through(const Address& relay, Endpoint& hub) {
  const std::unique_ptr<Endpoint> node = *open_udp_endpoint("127.0.0.1:0");
  std::array<std::byte, kMaxDatagramBytes> buffer;
  const bool came_back = wait_until([&] {
    node->send(relay, bytes_of("there"));
    if (const Received received = hub.receive(buffer, 0); received.bytes > 0) hub.send(received.from, bytes_of("back"));
    return node->receive(buffer, 0).bytes > 0;
  });
  EXPECT_TRUE(came_back);
  // A relay that forwards already handles SIGTERM.
  if (came_back) ::kill(::getpid(), SIGTERM);
}

nlohmann::json relay_report_of(const std::string& direction) {
  const ScratchFolder folder;
  const std::string report = (folder.path() / "relay.json").string();
  const std::unique_ptr<Endpoint> hub = *open_udp_endpoint("127.0.0.1:0");
  const Address relay = (*open_udp_endpoint("127.0.0.1:0"))->local_address();  // its endpoint is closed: the port is free
  std::thread sender([&] { talk_through(relay, *hub); });
  const CommandRun run = run_hapton({"relay", "--listen", to_string(relay), "--hub", to_string(hub->local_address()), "--direction",
                                     direction, "--duplicate", "1", "--seed", "42", "--seconds", "60", "--json", report});
  sender.join();
  EXPECT_EQ(run.code, 0) << run.err;
  std::ifstream file(report);
  return nlohmann::json::parse(file, nullptr, false);
}

TEST(RelayCommandTest, FaultsApplyInTheChosenDirection) {
  for (const std::string direction : {"to-hub", "to-nodes", "both"}) {
    const nlohmann::json report = relay_report_of(direction);
    ASSERT_TRUE(report.is_object()) << direction;
    EXPECT_EQ(report["seed"], 42);
    EXPECT_EQ(report["nodes_seen"], 1);
    for (const std::string way : {"to_hub", "to_nodes"}) {
      const bool has_faults = direction == "both" || (direction == "to-hub") == (way == "to_hub");
      const auto received = report[way]["received"].get<std::uint64_t>();
      EXPECT_GE(received, 1U) << direction << " " << way;
      EXPECT_EQ(report[way]["duplicated"].get<std::uint64_t>(), has_faults ? received : 0U) << direction << " " << way;
    }
  }
}

}  // namespace
}  // namespace hapton
