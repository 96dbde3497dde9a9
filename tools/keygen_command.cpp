#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "link/link_key.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct KeygenOptions {
  std::string file;
  std::string role;
  std::string master;
};

Result<LinkKey> find_master(const KeygenOptions& options) {
  if (!options.master.empty()) return read_key_file(options.master);
  const auto folder = find_shared_key_folder();
  if (!folder) return tl::unexpected(folder.error());
  return find_or_make_shared_key(*folder);
}

// Checks only the command line, no files.
Result<void> check(const KeygenOptions& options) {
  if (options.role.empty()) {
    if (!options.master.empty()) return fail("--master is for the key of a role; say which with --role, or leave --master out");
    return {};
  }
  if (find_node_key_role(options.role)) return {};
  return fail("role '{}' is not known; choose one of: haptics, vision, tool, operator", options.role);
}

Result<void> make(const KeygenOptions& options) {
  const auto role = find_node_key_role(options.role);
  if (!role) return make_key_file(options.file);
  const auto master = find_master(options);
  if (!master) return tl::unexpected(master.error());
  return make_role_key_file(options.file, *master, *role);
}

int run(const KeygenOptions& options) {
  if (const auto checked = check(options); !checked) {
    fmt::print(stderr, "hapton keygen: {}\n", checked.error().what);
    return 2;
  }
  if (const auto made = make(options); !made) {
    fmt::print(stderr, "hapton keygen: {}\n", made.error().what);
    return 1;
  }
  if (options.role.empty()) {
    fmt::print(
        "{0}: a new master key, readable by you alone; start io_node with --key {0}, and make a key for each node on another host: hapton "
        "keygen --role vision --master {0} vision.key\n",
        options.file);
  } else {
    fmt::print(
        "{0}: the key of role {1}{2}, readable by you alone; copy it to its host (scp -p) and start its program there with --key {0}\n",
        options.file, options.role, options.master.empty() ? ", from this user's own master key (of an io_node without --key)" : "");
  }
  return 0;
}

}  // namespace

void add_keygen_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<KeygenOptions>();
  const CommandLine command = app.add_subcommand("keygen", "Make the hub's master key, or a node's key from it");
  command.add_option("FILE", options->file, "File to write; an existing file is not changed").required();
  command.add_option("--role", options->role, "Make the key of this role: haptics, vision, tool, operator (a tool that may reset faults)");
  command.add_option("--master", options->master, "The hub's master key (default: this user's own)");
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
