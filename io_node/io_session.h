#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "io_node/device_thread.h"
#include "io_node/io_options.h"
#include "io_node/latch_file.h"
#include "io_node/network_loop.h"
#include "io_node/report_server.h"
#include "io_node/scheduling_monitor.h"
#include "io_node/service_liveness.h"
#include "io_node/stale_force_watchdog.h"
#include "link/metrics_endpoint.h"
#include "runtime/stop_signal.h"
#include "watchdog/watchdog_supervisor.h"

namespace hapton {

// Runs the device side and the network side in real-time threads, and meanwhile does everything that has no deadline: logs who joins and
// leaves, writes reports, checks for the end. RT: no, but those threads are real-time. Threads: call from one.
class IoSession {
 public:
  // Pre: all outlive the session.
  IoSession(NetworkLoop& network, const Clock& clock, const IoOptions& options);

  // Call this and the functions below before run. Serves the report to tools, and as metrics. Pre: the arguments outlive the session.
  void set_report_server(ReportServer* report_server) noexcept { report_server_ = report_server; }
  void set_metrics(MetricsEndpoint* metrics) noexcept { metrics_ = metrics; }
  // Restarts the watchdog process if it ends or hangs.
  void set_watchdog(WatchdogSupervisor* watchdog) noexcept { watchdog_ = watchdog; }
  // Keeps a latched fault in this file for the next start.
  void set_latch_file(const LatchFile* file) noexcept { latch_file_ = file; }

  // Tells the service manager that this session, one of several in the program, lives. number: its index among them.
  void set_service(ServiceLiveness* service, std::size_t number) noexcept {
    service_ = service;
    service_number_ = number;
  }

  // Runs until the seconds are over, a stop is requested, the device has ended, or a cycle is missed with --overrun stop. Error: that
  // cycle, real time required and denied, the device failed, or a report could not be written.
  Result<void> run(const StopSignal& stop);

  const std::string& realtime() const noexcept { return realtime_; }

 private:
  void run_network();
  bool is_over(const StopSignal& stop) const;
  Result<void> supervise(const StopSignal& stop);
  void note_requests(const StopSignal& stop);
  Result<void> serve_requests(const ServoStats& stats);
  void print_events();
  void keep_latch(const ServoEvent& event);
  std::string described(const ServoStats& stats) const;
  void watch_scheduling(bool is_due);
  void check_watchdog();
  void notify_service();
  Result<void> write_report_of(const ServoStats& stats);

  NetworkLoop& network_;
  const Clock& clock_;
  const IoOptions& options_;
  const std::string prefix_;  // at the start of each log line
  ReportServer* report_server_ = nullptr;
  MetricsEndpoint* metrics_ = nullptr;
  WatchdogSupervisor* watchdog_ = nullptr;
  const LatchFile* latch_file_ = nullptr;
  ServiceLiveness* service_ = nullptr;
  std::size_t service_number_ = 0;  // of this session in service_
  std::int64_t next_liveness_ns_ = 0;
  std::uint64_t cuts_reported_ = 0;
  // What the next copy of the statistics is for.
  bool file_requested_ = false;
  bool server_wants_report_ = false;
  bool metrics_requested_ = false;
  bool is_scraped_ = false;              // metrics were requested, and no copy of the statistics is under way for them
  std::uint32_t reports_requested_ = 0;  // by signal, since the start
  std::int64_t next_metrics_ns_ = 0;
  std::string realtime_;
  std::vector<std::string> realtime_lines_;
  Result<void> started_;
  std::atomic<bool> is_started_{false};
  std::atomic<bool> ends_{false};
  std::atomic<bool> has_ended_{false};
  std::int64_t end_ns_ = 0;
  pid_t network_thread_id_ = 0;
  DeviceThread device_thread_;
  StaleForceWatchdog stale_force_watchdog_;
  SchedulingMonitor scheduling_monitor_;
  std::int64_t next_scheduling_check_ns_ = 0;
};

}  // namespace hapton
