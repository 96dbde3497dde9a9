#include "tools/gnuplot.h"

#include <fstream>
#include <optional>
#include <system_error>

#include "tools/child_process.h"

namespace hapton {
namespace {

constexpr int kProgramNotFound = 127;  // exit code of a child of posix_spawnp, on some systems, if there is no such program

}  // namespace

Result<std::filesystem::path> draw_with_gnuplot(const std::filesystem::path& folder, const std::string& picture, const std::string& script,
                                                double timeout_s) {
  const std::string program = std::filesystem::path(picture).stem().string() + ".gnuplot.part";
  std::error_code error;
  std::filesystem::create_directories(folder, error);  // if this fails, the script cannot be written, which is reported
  // The script goes into a file, because gnuplot accepts data blocks only in a file, not on its command line.
  if (!(std::ofstream(folder / program) << script).flush()) {
    return fail("{}: cannot be written", (folder / program).string());
  }
  auto gnuplot = ChildProcess::start({.program = "gnuplot", .arguments = {program}, .folder = folder, .output = {}});
  const auto code = gnuplot ? gnuplot->wait(timeout_s) : std::optional<int>(kProgramNotFound);
  std::filesystem::remove(folder / program, error);
  if (code == kProgramNotFound) {
    return fail("gnuplot cannot be started, so no plot is drawn; install the package gnuplot-nox");
  }
  if (code != 0) {
    std::filesystem::remove(folder / (picture + ".part"), error);
    if (!code) {
      return fail("gnuplot took longer than {:g} s to draw {}, so it was stopped; try again", timeout_s, (folder / picture).string());
    }
    return fail("gnuplot could not draw {}; see its output above", (folder / picture).string());
  }
  std::filesystem::rename(folder / (picture + ".part"), folder / picture, error);
  if (error) {
    return fail("{}: cannot be written: {}", (folder / picture).string(), error.message());
  }
  return folder / picture;
}

}  // namespace hapton
