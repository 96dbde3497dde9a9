#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "link/address.h"
#include "link/link_key.h"
#include "tools/commands.h"
#include "tools/doctor/diagnosis.h"
#include "tools/doctor/display_check.h"
#include "tools/doctor/library_check.h"
#include "tools/live/hub_report.h"

namespace hapton {
namespace {

struct DoctorOptions {
  std::vector<std::string> only;
  bool json = false;
  std::string root = "/";
  int port = kDefaultHubPort;
  std::string key_file;
};

doctor::HubReply read_hub_reply(const DoctorOptions& options) {
  const auto reader = HubReader::open(fmt::format("127.0.0.1:{}", options.port), options.key_file);
  if (!reader) return {reader.error().what, {}};
  const auto report = (*reader)->read();
  if (!report) return {report.error().what, {}};
  return {{}, report->json};
}

// With another root, the libraries, display and hub of this machine are not checked.
doctor::Machine::Queries queries_for(const DoctorOptions& options) {
  if (options.root != "/") return {};
  return {.library = doctor::try_vendor_library, .display = doctor::try_display, .hub = [&options] { return read_hub_reply(options); }};
}

int run(const DoctorOptions& options) {
  const std::string key = options.key_file.empty() ? "" : std::filesystem::absolute(options.key_file).lexically_normal().string();
  const doctor::Machine machine(options.root, queries_for(options), {.hub_port = options.port, .key_file = key});
  const doctor::Diagnosis diagnosis = doctor::diagnose(machine, options.only);
  const bool with_colours = ::isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  fmt::print("{}", options.json ? doctor::to_json(diagnosis) : doctor::to_text(diagnosis, with_colours));
  std::fflush(stdout);
  return diagnosis.is_fit() ? 0 : 1;
}

std::vector<std::string> names_of_checks() {
  std::vector<std::string> names;
  for (const doctor::Check& check : doctor::all_checks()) names.emplace_back(check.name);
  return names;
}

std::string describe_checks() {
  std::string text = "Only this check, may be repeated:";
  for (const doctor::Check& check : doctor::all_checks()) text += fmt::format(" {} ({});", check.name, check.about);
  text.back() = '.';
  return text;
}

}  // namespace

void add_doctor_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  const CommandLine command =
      app.add_subcommand("doctor", "Check devices, rights, timing, network and display, and print how to fix what is wrong");
  command.add_option("--only", options->only, describe_checks()).one_of(names_of_checks()).again_for_more();
  command.add_flag("--json", options->json, "For programs: schema hapton.doctor/1");
  command.add_option("--port", options->port, "The hub's UDP port").between(1, 65535).shows_default();
  command.add_option("--key", options->key_file, kKeyHelp);
  command.add_option("--root", options->root, "Check the files of another machine's root (for support and tests); nothing is loaded")
      .existing_folder()
      .shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
