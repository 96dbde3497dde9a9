#include <fmt/core.h>

#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/turn_by_degrees.h"
#include "link/hub_connection.h"
#include "link/move_request.h"
#include "tools/commands.h"
#include "tools/number_list.h"

namespace hapton {
namespace {

struct MoveOptions {
  std::string object;
  std::string to;
  std::string rotate;
  std::optional<double> over_s;
  HubConnection::Settings hub;
};

constexpr double kMoveJoinTimeoutS = 2.0;  // how long to wait for the hub; this and the next value are free choices
constexpr double kMoveReplyTimeoutS = 5.0;
// If the time is longer than requested by more than this share, the move was slowed down: it is not only rounding.
constexpr double kSlowedShare = 1e-6;

Result<MoveTarget> read_target(const MoveOptions& options) {
  MoveTarget target{.over_s = options.over_s};
  if (!options.to.empty()) {
    const auto numbers = read_number_list(options.to);
    if (!numbers || numbers->size() != 3) return fail("--to {}: give three numbers in metres, X,Y,Z", options.to);
    target.position_m = Vec3(numbers->data());
  }
  if (!options.rotate.empty()) {
    const auto numbers = read_number_list(options.rotate);
    if (!numbers || (numbers->size() != 3 && numbers->size() != 4)) {
      return fail("--rotate {}: give three angles in degrees, X,Y,Z, or a quaternion W,X,Y,Z", options.rotate);
    }
    const std::vector<double>& n = *numbers;
    target.rotation = n.size() == 4 ? Quat(n[0], n[1], n[2], n[3]) : turn_by_degrees(Vec3(n.data()));
  }
  if (!target.position_m && !target.rotation) return fail("nothing to move to; give --to, --rotate, or both");
  return target;
}

Result<MoveRequest> read_move(const MoveOptions& options) {
  const auto target = read_target(options);
  if (!target) return tl::unexpected(target.error());
  return make_move_request(options.object, *target);
}

Result<double> move(const MoveOptions& options, const MoveRequest& request) {
  const auto connection = HubConnection::open(NodeRole::tool, options.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kMoveJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  return move_object((*connection)->client(), (*connection)->clock(), request, kMoveReplyTimeoutS);
}

// The exit code, as for any other invalid command line.
constexpr int kBadMove = 2;

int run(const MoveOptions& options) {
  const auto request = read_move(options);
  const auto seconds = request ? move(options, *request) : tl::unexpected(request.error());
  if (!seconds) {
    fmt::print(stderr, "hapton move: {}\n", seconds.error().what);
    return request ? 1 : kBadMove;
  }
  const bool is_slowed = options.over_s && *seconds > *options.over_s * (1.0 + kSlowedShare);
  fmt::print("{} moves, for {:.3f} s{}\n", options.object, *seconds,
             is_slowed ? fmt::format(", not {:g} s: no point of it may be faster than 0.25 m/s", *options.over_s) : "");
  return 0;
}

}  // namespace

void add_move_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<MoveOptions>();
  const CommandLine command = app.add_subcommand("move", "Move an object of a running scene that has moved_by = \"program\"");
  command.add_option("object", options->object, "Name of the object in the scene, or #N, its number from 0").required();
  command.add_option("--to", options->to,
                     "Its position after the move, X,Y,Z in m, as position_m in the scene file; left out: its pivot does not move");
  command.add_option("--rotate", options->rotate,
                     "Its rotation after the move, X,Y,Z in degrees or a quaternion W,X,Y,Z, as in the scene file; left out: it does "
                     "not turn");
  command.add_option("--over", options->over_s, "Duration of the move, s; left out, or too short: as fast as a surface may move (0.25 m/s)")
      .positive("seconds");
  command.add_option("--hub", options->hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->hub.key_file, kKeyHelp);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
