#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "runtime/file_watch.h"
#include "runtime/stoppable_calls.h"
#include "scene/scene_file.h"

namespace hapton {

// Reads the scene file again when it was saved, in a thread of its own: no frame waits for it, and neither does the end of the program. A
// file with an error is one line in the log, and in problem(). Threads: take() from one; poll() from one, that of start() if it was called.
// RT: no.
class SceneReload {
 public:
  using Read = std::function<Result<Scene>(const std::filesystem::path& path, const SceneLoading& loading)>;

  // The file as it is now is known. Pre: `read` may outlive this.
  SceneReload(std::filesystem::path path, const SceneLoading& loading, Read read = load_scene);
  ~SceneReload();
  SceneReload(const SceneReload&) = delete;
  SceneReload& operator=(const SceneReload&) = delete;

  // Looks twice a second from now on, in its thread.
  void start();
  // One look: a file that was saved, and is the same at the next look, is read then.
  void poll();

  // The newest scene that was read since the last call; none: nothing was.
  std::optional<Scene> take();
  // Why the file as it is now cannot be shown, in one line with its name, without its folder; empty: it can, or is not read yet. Threads:
  // any.
  std::string problem();
  // The file was saved, and what it has now is not read yet. Threads: any.
  bool is_reading() const { return is_reading_.load(); }

  const std::filesystem::path& path() const { return path_; }

 private:
  void run();
  void read();
  void set_gone(bool is_gone);

  std::filesystem::path path_;
  SceneLoading loading_;
  Read read_file_;
  FileWatch file_;
  std::mutex mutex_;
  std::optional<Scene> read_;
  std::string error_;     // of the newest content that was read
  bool is_gone_ = false;  // there is no file
  std::atomic<bool> is_reading_ = false;
  StoppableCalls calls_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hapton
