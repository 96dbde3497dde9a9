#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"
#include "vision_node/carved_objects.h"

namespace hapton {

// A person's work as it is in the picture.
struct WindowWork {
  const Scene& scene;
  const Annotations& placed;  // strokes and measures in the present shape of their objects
  const ObjectPoses& X_SO;
  const CarvedObjects* carved = nullptr;  // null: nothing is carved
};

// Writes a person's work for other programs, under the next free number: strokes and measures as hapton_export_001.vtp, the surface of each
// object that is carved as hapton_export_001_NAME.stl, S, metres. Each file is there as a whole or not at all. It is computed and written
// in a thread of its own, one export after the other: no frame waits for it. Threads: all calls from one. RT: no.
class WindowExport {
 public:
  explicit WindowExport(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~WindowExport() { finish(); }
  WindowExport(const WindowExport&) = delete;
  WindowExport& operator=(const WindowExport&) = delete;

  // Begins to export the work as it is now, also if it changes before it is written.
  void begin(const WindowWork& work);

  // A line for the picture, once: an export has begun, is written (with the names of its files), or failed; the log has it as well. Empty:
  // none of these since the last call.
  std::string take_notice();

  // At the end: returns when all that was begun is written, or has failed.
  void finish();

 private:
  struct Job {
    std::vector<std::string> names;  // of the scene's objects
    Annotations placed;
    ObjectPoses X_SO;
    std::future<CarvedObjects::Fields> bodies;  // not valid: nothing is carved
  };
  // The part of a file's name after its number, and what it has.
  struct Part {
    std::string ending;
    std::string bytes;
  };

  void run();
  void report(const Result<std::string>& written);
  Result<std::string> write(Job& job) const;
  static std::vector<Part> make_parts(Job& job);

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;  // that are not begun
  bool is_writing_ = false;
  bool is_ending_ = false;
  std::string notice_;
  std::thread thread_;
};

}  // namespace hapton
