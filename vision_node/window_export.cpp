#include "vision_node/window_export.h"

#include <sys/resource.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include <fmt/format.h>

#include "core/sculpt/carved_mesh.h"
#include "runtime/atomic_file.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "scene/annotations_file.h"
#include "scene/mesh_text.h"

namespace hapton {
namespace {

// Low priority: the computation of forces and the picture get the processor first.
constexpr int kExportNiceness = 10;

// Replaces characters that could trouble a file name: names in a scene file may have any characters.
std::string name_for_file(const std::string& name) {
  std::string letters = name;
  for (char& letter : letters) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0 && letter != '-') letter = '_';
  }
  return letters;
}

bool has_name_alone(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::count(names, name, name_for_file) == 1;
}

}  // namespace

void WindowExport::begin(const WindowWork& work) {
  const bool is_carved = work.carved != nullptr && work.carved->list().newest_active() != 0;
  if (work.placed_annotations.entries.empty() && !is_carved) {
    const std::lock_guard lock(mutex_);
    notice_ = "nothing to export: nothing is drawn, measured or carved";
    log_info("{}", notice_);
    return;
  }
  Job job{.names = {}, .placed_annotations = work.placed_annotations, .X_SO = work.X_SO, .bodies = {}};
  for (const SceneObject& object : work.scene.objects) job.names.push_back(object.name);
  if (is_carved) job.bodies = work.carved->request_fields();
  {
    const std::lock_guard lock(mutex_);
    if (is_carved) notice_ = "exporting ...";
    jobs_.push_back(std::move(job));
  }
  if (!thread_.joinable()) thread_ = start_thread([this] { run(); });
  changed_.notify_one();
}

std::string WindowExport::take_notice() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notice_, {});
}

void WindowExport::finish() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    if (is_writing_ || !jobs_.empty()) log_info("finishing the export before the program ends");
  }
  changed_.notify_one();
  thread_.join();
  is_ending_ = false;
}

void WindowExport::run() {
  (void)::setpriority(PRIO_PROCESS, 0, kExportNiceness);  // on Linux: of this thread only
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    is_writing_ = true;
    lock.unlock();
    const auto written = write(job);
    lock.lock();
    is_writing_ = false;
    report(written);
  }
}

// Pre: the mutex is held.
void WindowExport::report(const Result<std::string>& written) {
  if (written) log_info("{}", *written);
  if (!written) log_warning("not exported: {}", written.error().what);
  notice_ = written ? *written : "NOT EXPORTED: " + written.error().what;
}

std::vector<WindowExport::Part> WindowExport::make_parts(Job& job) {
  std::vector<Part> parts;
  if (!job.placed_annotations.entries.empty())
    parts.push_back({".vtp", write_annotations_vtp(job.placed_annotations, job.X_SO, job.names.size())});
  if (!job.bodies.valid()) return parts;
  for (const auto& [object, field] : job.bodies.get()) {
    std::string name = name_for_file(job.names[object]);
    if (!has_name_alone(job.names, name)) name = fmt::format("{}_{}", object, name);
    // A name with a number may be that of another object.
    const auto is_used = [&] { return std::ranges::any_of(parts, [&](const Part& part) { return part.ending == "_" + name + ".stl"; }); };
    while (is_used()) name = fmt::format("{}_{}", object, name);
    parts.push_back({"_" + name + ".stl", write_mesh(make_carved_mesh(field), MeshTextFormat::stl)});
  }
  return parts;
}

Result<std::string> WindowExport::write(Job& job) const {
  const std::vector<Part> parts = make_parts(job);
  if (parts.empty()) return fail("no surface could be computed; see the lines before this one");
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::absolute(folder_, error);
  std::filesystem::path stem;
  const auto is_there = [&](const Part& part) { return std::filesystem::exists(stem.string() + part.ending, error); };
  int number = 1;
  do {
    stem = folder / fmt::format("hapton_export_{:03}", number++);
  } while (std::ranges::any_of(parts, is_there));
  std::string names;
  for (const Part& part : parts) {
    const std::filesystem::path file = stem.string() + part.ending;
    if (auto written = write_file_atomically(file, part.bytes); !written) return tl::unexpected(written.error());
    names += (names.empty() ? " " : ", ") + file.filename().string();
  }
  return "exported to " + folder.lexically_normal().string() + ":" + names;
}

}  // namespace hapton
