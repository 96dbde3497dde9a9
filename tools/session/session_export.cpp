#include "tools/session/session_export.h"

#include <cerrno>
#include <cstring>
#include <string>

#include "runtime/atomic_file.h"

namespace hapton {

Result<SessionExport> SessionExport::open(const std::filesystem::path& folder, std::int64_t start_ns) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("{}: the folder cannot be made: {}", folder.string(), error.message());
  SessionExport made;
  made.folder_ = folder;
  made.start_ns_ = start_ns;
  const struct {
    File& file;
    const char* name;
    const char* columns;
  } tables[] = {
      {made.trajectory_, "trajectory.csv", "t_s,x_m,y_m,z_m,qw,qx,qy,qz,sample\n"},
      {made.forces_, "forces.csv", "t_s,sample,fx_n,fy_n,fz_n,contact,offset_x_m,offset_y_m,offset_z_m,round_trip_us,compute_us\n"},
      {made.cycles_, "cycles.csv", "t_s,sample,late_us,written_x_n,written_y_n,written_z_n,missed,cause\n"}};
  for (const auto& table : tables) {
    const auto path = folder / table.name;
    table.file.reset(open_file_for(path, FileReaders::everyone));
    if (!table.file || std::fputs(table.columns, table.file.get()) < 0) {
      return fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
    }
  }
  return made;
}

void SessionExport::add(const SessionEntry& entry, const Datagram* datagram) {
  if (entry.kind == SessionEntry::Kind::cycle) {
    const CycleNote& c = entry.cycle;
    ++rows_.cycles;
    good_ = good_ && std::fprintf(cycles_.get(), "%.9f,%llu,%.3f,%.17g,%.17g,%.17g,%u,%s\n", seconds(entry.time_ns),
                                  static_cast<unsigned long long>(c.sample), 1e-3 * static_cast<double>(c.late_ns), c.written_n.x(),
                                  c.written_n.y(), c.written_n.z(), c.missed, std::string(to_string(c.cause)).c_str()) > 0;
  }
  if (datagram == nullptr) return;
  const auto* state = std::get_if<DeviceState>(&datagram->message);
  // Each sample once, its times rising.
  if (state != nullptr && entry.kind == SessionEntry::Kind::sent && state->sample > last_sample_) {
    last_sample_ = state->sample;
    ++rows_.trajectory;
    good_ = good_ && std::fprintf(trajectory_.get(), "%.9f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%llu\n",
                                  seconds(state->sample_time_ns), state->p_WD.x(), state->p_WD.y(), state->p_WD.z(), state->q_WT.w(),
                                  state->q_WT.x(), state->q_WT.y(), state->q_WT.z(), static_cast<unsigned long long>(state->sample)) > 0;
  }
  const auto* force = std::get_if<ForceCommand>(&datagram->message);
  if (force != nullptr && entry.kind == SessionEntry::Kind::received) {
    ++rows_.forces;
    good_ = good_ && std::fprintf(forces_.get(), "%.9f,%llu,%.17g,%.17g,%.17g,%d,%.17g,%.17g,%.17g,%.3f,%.3f\n", seconds(entry.time_ns),
                                  static_cast<unsigned long long>(force->echo_sample), force->force_n.x(), force->force_n.y(),
                                  force->force_n.z(), force->contact ? 1 : 0, force->visual_offset_m.x(), force->visual_offset_m.y(),
                                  force->visual_offset_m.z(), 1e-3 * static_cast<double>(entry.time_ns - force->echo_sample_time_ns),
                                  1e-3 * static_cast<double>(force->compute_ns)) > 0;
  }
}

Result<void> SessionExport::close() {
  for (File* file : {&trajectory_, &forces_, &cycles_}) good_ = std::fclose(file->release()) == 0 && good_;
  if (!good_) return fail("{}: the tables could not be written to their end: {}", folder_.string(), std::strerror(errno));
  return {};
}

}  // namespace hapton
