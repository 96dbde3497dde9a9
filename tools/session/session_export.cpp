#include "tools/session/session_export.h"

#include <cstdio>
#include <string>

#include "tools/session/csv_names.h"

namespace hapton {
namespace {

std::string object_text(std::int32_t object) { return object < 0 ? std::string() : std::to_string(object); }

}  // namespace

Result<SessionExport> SessionExport::open(const std::filesystem::path& folder, std::int64_t start_ns, std::vector<ObjectName> names) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("{}: the folder cannot be made: {}", folder.string(), error.message());
  SessionExport made;
  made.start_ns_ = start_ns;
  made.shapes_.emplace(folder, start_ns, names);
  made.names_ = std::move(names);
  const struct {
    std::optional<PartFile>& file;
    const char* name;
    const char* columns;
  } tables[] = {
      {made.trajectory_, "trajectory.csv", "t_s,x_m,y_m,z_m,qw,qx,qy,qz,sample\n"},
      {made.forces_, "forces.csv",
       "t_s,sample,fx_n,fy_n,fz_n,contact,offset_x_m,offset_y_m,offset_z_m,round_trip_us,compute_us,object,object_name,material,tx_nm,ty_"
       "nm,"
       "tz_nm,turn_x_rad,turn_y_rad,turn_z_rad,haptons\n"},
      {made.cycles_, "cycles.csv",
       "t_s,sample,late_us,written_x_n,written_y_n,written_z_n,missed,cause,sample_t_s,x_m,y_m,z_m,qw,qx,qy,qz,buttons,local_x_n,local_y_n,"
       "local_z_n,local_object,written_tx_nm,written_ty_nm,written_tz_nm\n"}};
  for (const auto& table : tables) {
    auto opened = PartFile::open(folder / table.name);
    if (!opened) return tl::unexpected(opened.error());
    table.file.emplace(std::move(*opened));
    table.file->check(std::fputs(table.columns, table.file->get()) >= 0);
  }
  return made;
}

// Fields that were not recorded stay empty.
void SessionExport::add_cycle(const SessionEntry& entry) {
  const CycleNote& c = entry.cycle;
  ++rows_.cycles;
  std::FILE* file = cycles_->get();
  cycles_->check(std::fprintf(file, "%.9f,%llu,%.3f,%.17g,%.17g,%.17g,%u,%s", seconds(entry.time_ns),
                              static_cast<unsigned long long>(c.sample), 1e-3 * static_cast<double>(c.late_ns), c.written_n.x(),
                              c.written_n.y(), c.written_n.z(), c.missed, std::string(to_string(c.cause)).c_str()) > 0);
  if (c.device) {
    const Quat& q = c.device->q_WT;
    const Vec3& p = c.device->p_WD;
    cycles_->check(std::fprintf(file, ",%.9f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%u", seconds(c.device->time_ns), p.x(), p.y(), p.z(),
                                q.w(), q.x(), q.y(), q.z(), c.device->buttons) > 0);
  } else {
    cycles_->check(std::fputs(",,,,,,,,,", file) >= 0);
  }
  cycles_->check(c.local ? std::fprintf(file, ",%.17g,%.17g,%.17g,%s", c.local->force_n.x(), c.local->force_n.y(), c.local->force_n.z(),
                                        object_text(c.local->object).c_str()) > 0
                         : std::fputs(",,,,", file) >= 0);
  cycles_->check(std::fprintf(file, ",%.17g,%.17g,%.17g\n", c.written_nm.x(), c.written_nm.y(), c.written_nm.z()) > 0);
  if (c.device) add_sample(c.sample, c.device->time_ns, c.device->p_WD, c.device->q_WT);
}

// Writes each sample once, in the order of time, from the first entry that has it: the message that was sent, or the servo cycle.
void SessionExport::add_sample(std::uint64_t sample, std::int64_t time_ns, const Vec3& p_WD, const Quat& q) {
  if (sample <= last_sample_) return;
  last_sample_ = sample;
  ++rows_.trajectory;
  trajectory_->check(std::fprintf(trajectory_->get(), "%.9f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%llu\n", seconds(time_ns), p_WD.x(),
                                  p_WD.y(), p_WD.z(), q.w(), q.x(), q.y(), q.z(), static_cast<unsigned long long>(sample)) > 0);
}

void SessionExport::add(const SessionEntry& entry, const Datagram* datagram) {
  if (entry.kind == SessionEntry::Kind::cycle) add_cycle(entry);
  shapes_->add(entry, datagram);
  if (datagram == nullptr) return;
  const auto* state = std::get_if<DeviceState>(&datagram->message);
  if (state != nullptr && entry.kind == SessionEntry::Kind::sent)
    add_sample(state->sample, state->sample_time_ns, state->p_WD, state->q_WT);
  const auto* force = std::get_if<ForceCommand>(&datagram->message);
  if (force != nullptr && entry.kind == SessionEntry::Kind::received) {
    ++rows_.forces;
    forces_->check(std::fprintf(forces_->get(), "%.9f,%llu,%.17g,%.17g,%.17g,%d,%.17g,%.17g,%.17g,%.3f,%.3f,%s,%s", seconds(entry.time_ns),
                                static_cast<unsigned long long>(force->echo_sample), force->force_n.x(), force->force_n.y(),
                                force->force_n.z(), force->contact ? 1 : 0, force->visual_offset_m.x(), force->visual_offset_m.y(),
                                force->visual_offset_m.z(),
                                1e-3 * static_cast<double>(ns_between(force->echo_sample_time_ns, entry.time_ns)),
                                1e-3 * static_cast<double>(force->compute_ns), object_text(force->object).c_str(),
                                csv_names(names_, force->object).c_str()) > 0);
    const Vec3& torque = force->torque_nm;
    const Vec3& turn = force->visual_turn;
    forces_->check(std::fprintf(forces_->get(), ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%s\n", torque.x(), torque.y(), torque.z(), turn.x(),
                                turn.y(), turn.z(), force->haptons ? std::to_string(*force->haptons).c_str() : "") > 0);
  }
}

Result<void> SessionExport::close() {
  for (auto* file : {&trajectory_, &forces_, &cycles_}) {
    if (auto closed = (*file)->close(); !closed) return closed;
  }
  if (auto closed = shapes_->close(); !closed) return closed;
  for (auto* file : {&trajectory_, &forces_, &cycles_}) {
    if (auto kept = (*file)->keep(); !kept) return kept;
  }
  return shapes_->keep();
}

}  // namespace hapton
