#include "tools/keygen_command.h"

#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "link/link_key.h"

namespace hapton {
namespace {

int run(const std::string& file) {
  if (const auto made = make_key_file(file); !made) {
    fmt::print(stderr, "hapton keygen: {}\n", made.error().what);
    return 1;
  }
  fmt::print("{}: a new key, readable by you alone; copy it to every machine (scp -p) and start every node with --key {}\n", file, file);
  return 0;
}

}  // namespace

void add_keygen_command(CommandLine app, int& exit_code) {
  auto file = std::make_shared<std::string>();
  const CommandLine command = app.add_subcommand("keygen", "Make the key file that the nodes of a system share");
  command.add_option("FILE", *file, "Where to put it; what is there already stays as it is").required();
  command.on_run([file, &exit_code] { exit_code = run(*file); });
}

}  // namespace hapton
