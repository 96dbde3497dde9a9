#include "vision_node/scene_reload.h"

#include <sys/resource.h>

#include <chrono>
#include <utility>

#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// As in SceneWatcher of haptics_node. A saved file is read at the second check that finds it in the same state.
constexpr std::chrono::milliseconds kPollPeriod(500);
// Low priority: the computation of forces gets the processor first.
constexpr int kReloadNiceness = 10;

// The picture has no room for the folders of a path, nor for the list of all known keys; the log shows both.
std::string shorten(std::string text, const std::filesystem::path& path) {
  const std::string whole = path.string();
  if (const std::size_t at = text.find(whole); at != std::string::npos) text.replace(at, whole.size(), path.filename().string());
  return text.substr(0, text.find("; known are "));
}

}  // namespace

SceneReload::SceneReload(std::filesystem::path path, const SceneLoading& loading, Read read)
    : path_(std::move(path)), loading_(loading), read_file_(std::move(read)), file_watch_(path_) {}

SceneReload::~SceneReload() {
  calls_.stop();
  if (thread_.joinable()) thread_.join();
}

void SceneReload::start() {
  thread_ = start_thread([this] { run(); });
}

void SceneReload::run() {
  (void)::setpriority(PRIO_PROCESS, 0, kReloadNiceness);  // on Linux: of this thread only
  do {
    poll();
  } while (calls_.sleep(kPollPeriod));
}

void SceneReload::poll() {
  const FileWatch::State state = file_watch_.check();
  set_gone(file_watch_.is_gone());
  switch (state) {
    case FileWatch::State::gone:
      is_reading_.store(false);
      log_warning("{} is gone; the present picture stays, and the file is read once it is back", path_.string());
      return;
    case FileWatch::State::unchanged:
      is_reading_.store(false);
      return;
    case FileWatch::State::waiting:
      is_reading_.store(true);
      return;
    case FileWatch::State::changed:
      file_watch_.accept();
      read();
      is_reading_.store(false);
  }
}

void SceneReload::read() {
  auto result = calls_.call([read = read_file_, path = path_, loading = loading_] { return read(path, loading); });
  if (!result) return;  // the program ends
  Result<Scene>& scene = *result;
  const std::lock_guard lock(mutex_);
  error_ = scene ? std::string() : shorten(scene.error().what, path_);
  if (!scene) {
    log_warning("{}; the present picture stays", scene.error().what);
    return;
  }
  for (const auto& note : scene->notes) log_info("{}", note);
  new_scene_ = std::move(*scene);
}

void SceneReload::set_gone(bool is_gone) {
  const std::lock_guard lock(mutex_);
  is_gone_ = is_gone;
}

std::string SceneReload::problem() {
  const std::lock_guard lock(mutex_);
  return is_gone_ ? path_.filename().string() + " is gone" : error_;
}

std::optional<Scene> SceneReload::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(new_scene_, std::nullopt);
}

}  // namespace hapton
