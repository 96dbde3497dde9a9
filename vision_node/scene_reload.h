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

  // The present content counts as read: only later changes are read. Pre: `read` may still run after the end of this (StoppableCalls).
  SceneReload(std::filesystem::path path, const SceneLoading& loading, Read read = load_scene);
  ~SceneReload();
  SceneReload(const SceneReload&) = delete;
  SceneReload& operator=(const SceneReload&) = delete;

  // From now on polls twice a second, in a thread of its own.
  void start();
  // Checks the file once. A file that was saved, and has not changed again by the next check, is read then.
  void poll();

  // The newest scene that was read since the last call; none: no scene was read.
  std::optional<Scene> take();
  // Why the file as it was read last cannot be shown, or that it is gone: a line with its name, without its folder; empty: it can. Threads:
  // any.
  std::string problem();
  // True: the file was saved, and its present content has not been read yet. Threads: any.
  bool is_reading() const { return is_reading_.load(); }

  const std::filesystem::path& path() const { return path_; }

 private:
  void run();
  void read();
  void set_gone(bool is_gone);

  std::filesystem::path path_;
  SceneLoading loading_;
  Read read_file_;
  FileWatch file_watch_;
  std::mutex mutex_;
  std::optional<Scene> new_scene_;
  std::string error_;     // error in the newest content that was read
  bool is_gone_ = false;  // there is no file
  std::atomic<bool> is_reading_ = false;
  StoppableCalls calls_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hapton
