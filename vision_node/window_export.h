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

// A person's work (strokes, measures, carves) as the picture shows it.
struct WindowWork {
  const Scene& scene;
  const Annotations& placed_annotations;  // strokes and measures in the present shape of their objects
  const ObjectPoses& X_SO;
  const CarvedObjects* carved = nullptr;  // null: nothing is carved
};

// Writes a person's work for other programs, under the next free number: strokes and measures as hapton_export_001.vtp, the surface of each
// carved object as hapton_export_001_NAME.stl. Frame S, metres. Each file is written as a whole or not at all. A thread of its own computes
// and writes one export after the other, so that no frame waits. Threads: all calls from one thread. RT: no.
class WindowExport {
 public:
  explicit WindowExport(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~WindowExport() { finish(); }
  WindowExport(const WindowExport&) = delete;
  WindowExport& operator=(const WindowExport&) = delete;

  // Begins to export the work as it is now; later changes of the work are not exported.
  void begin(const WindowWork& work);

  // A line for the picture, once: an export of carved objects has begun; or (also in the log) an export is written, with the names of its
  // files, or failed, or there is nothing to export. Empty: none of these since the last call.
  std::string take_notice();

  // At the end of the program: returns once every export that was begun is written or has failed.
  void finish();

 private:
  struct Job {
    std::vector<std::string> names;  // names of the scene's objects
    Annotations placed_annotations;
    ObjectPoses X_SO;
    std::future<CarvedObjects::Fields> bodies;  // not valid: nothing is carved
  };
  // One file of an export: the part of its name after the number, and its content.
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
  std::deque<Job> jobs_;  // exports that are not begun yet
  bool is_writing_ = false;
  bool is_ending_ = false;
  std::string notice_;
  std::thread thread_;
};

}  // namespace hapton
