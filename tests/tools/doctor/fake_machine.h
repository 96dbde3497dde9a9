#pragma once

#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// A machine made of files in a folder, and of prepared replies. Nothing is wrong with it until a test changes something. A WoodenHaptics
// (hidraw0), a Touch (ttyACM0) and a SpaceMouse (hidraw1) are plugged in, io_node runs, the user is "ada". The files belong to the user who
// runs the test, so ada has the rights of their group: plugdev has the number of the group of that user.
class FakeMachine {
 public:
  FakeMachine() {
    write_user();
    write_timing();
    write_devices();
    write_network();
    replies.library = [](std::string_view name) {
      return name == "OpenHaptics" ? LibraryReply{"libHD.so.3.4", {}, {}}
                                   : LibraryReply{{}, {{"libdrd.so", kLibdrdError, "install it"}}, {}};
    };
    replies.display = [] { return DisplayReply{{}, "NVIDIA RTX A4000/PCIe/SSE2", "4.6.0", true, true}; };
    replies.hub = [] {
      return HubReply{{}, R"({"notes": {"device": "openhaptics", "device_model": "Touch", "device_firmware": "192",
      "device_state": "ready", "device_calibrated": "yes", "motor_temperature": "0.2",
      "realtime": "real time: priority SCHED_FIFO 80: granted"}})"};
    };
  }

  static constexpr const char* kLibdrdError = "libdrd.so: cannot open shared object file: No such file or directory";

  void write(const std::string& path, const std::string& text, mode_t mode = 0644) const {
    const std::filesystem::path file = root() / path.substr(1);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    ::chmod(file.c_str(), mode);
  }
  void link(const std::string& path, const std::string& target) const {
    const std::filesystem::path file = root() / path.substr(1);
    std::filesystem::create_directories(file.parent_path());
    std::filesystem::remove(file);
    std::filesystem::create_symlink(target, file);
  }
  void remove(const std::string& path) const { std::filesystem::remove_all(root() / path.substr(1)); }
  void make_folder(const std::string& path) const { std::filesystem::create_directories(root() / path.substr(1)); }
  void set_mode(const std::string& path, mode_t mode) const { ::chmod((root() / path.substr(1)).c_str(), mode); }

  // The user's ID and rights, as the kernel shows them. groups: numbers of the groups besides the primary one.
  void set_user(uid_t uid, const std::string& groups, const std::string& capabilities = "0000000000000000") const {
    write("/proc/self/status",
          fmt::format("Name:\thapton\nUid:\t{0}\t{0}\t{0}\t{0}\nGid:\t7777\t7777\t7777\t7777\nGroups:\t{1}\nCapEff:\t{2}\n", uid, groups,
                      capabilities));
    write("/etc/passwd", fmt::format("root:x:0:0::/root:/bin/bash\nada:x:{}:7777::/home/ada:/bin/bash\n", uid));
  }
  void set_limits(const std::string& priority, const std::string& memory) const {
    write("/proc/self/limits", fmt::format("Limit                     Soft Limit           Hard Limit           Units     \n"
                                           "Max locked memory         {:<20} {:<20} bytes     \n"
                                           "Max realtime priority     {:<20} {:<20}           \n",
                                           memory, memory, priority, priority));
  }
  void set_environment(const std::string& entries) const { write("/proc/self/environ", entries); }
  void run_program(const std::string& pid, const std::string& name) const { write("/proc/" + pid + "/comm", name + "\n"); }
  // A socket at a port, held by a program that runs. table: udp, udp6 or tcp.
  void hold_port(const std::string& table, int port, const std::string& pid, const std::string& program) const {
    run_program(pid, program);
    write("/proc/net/" + table,
          fmt::format("  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
                      "   0: 0100007F:{:04X} 00000000:0000 {} 00000000:00000000 00:00000000 00000000  1000        0 {}5 2 0000 0\n",
                      port, table == "tcp" ? "0A" : "07", pid));
    link("/proc/" + pid + "/fd/3", "socket:[" + pid + "5]");
  }
  gid_t own_group() const { return ::getgid(); }
  uid_t another_uid() const { return ::getuid() + 1; }
  std::string user_groups() const { return fmt::format("{} 7001", own_group()); }

  Machine make() const { return Machine(root(), replies, settings); }
  const std::filesystem::path& root() const { return scratch_.path(); }

  Machine::Queries replies;
  Machine::Settings settings;

 private:
  void write_user() const {
    set_user(another_uid(), user_groups());
    write("/etc/group", fmt::format("root:x:0:\nplugdev:x:{}:ada\nhapton:x:7001:ada\n", own_group()));
    set_limits("90", "unlimited");
    set_environment(std::string("HOME=/home/ada\0DISPLAY=:0\0", 25));
  }

  void write_timing() const {
    write("/proc/version", "Linux version 6.1.0-rt (x) #1 SMP PREEMPT_RT Debian\n");
    write("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu tsc avx2\n");
    write("/proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("/sys/kernel/realtime", "1\n");
    write("/sys/devices/system/cpu/online", "0-7\n");
    write("/sys/devices/system/cpu/isolated", "\n");
    for (const char* cpu : {"cpu0", "cpu1"}) {
      write(fmt::format("/sys/devices/system/cpu/{}/cpufreq/scaling_governor", cpu), "performance\n");
      write(fmt::format("/sys/devices/system/cpu/{}/cpufreq/scaling_driver", cpu), "acpi-cpufreq\n");
    }
    write_sleep_state(0, "POLL", 0);
    write_sleep_state(1, "C10", 890);
    write("/dev/cpu_dma_latency", "", 0660);
    write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("/sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm \n");
  }
  void write_sleep_state(int number, const std::string& name, int latency_us) const {
    const std::string folder = fmt::format("/sys/devices/system/cpu/cpu0/cpuidle/state{}", number);
    write(folder + "/name", name + "\n");
    write(folder + "/latency", fmt::format("{}\n", latency_us));
    write(folder + "/disable", "0\n");
  }

  void write_usb(const std::string& port, const std::string& vid, const std::string& pid, const std::string& product,
                 const std::string& driver) const {
    const std::string folder = "/sys/devices/usb1/" + port;
    write(folder + "/idVendor", vid + "\n");
    write(folder + "/idProduct", pid + "\n");
    write(folder + "/product", product + "\n");
    write(folder + "/serial", "SN" + port + "\n");
    write(folder + "/busnum", "1\n");
    write(folder + "/devnum", "4\n");
    write(folder + "/power/control", "on\n");
    write(folder + "/" + port + ":1.0/bInterfaceClass", "03\n");
    link(folder + "/" + port + ":1.0/driver", "../../../../bus/usb/drivers/" + driver);
    link("/sys/bus/usb/devices/" + port, "../../../devices/usb1/" + port);
  }
  void write_hidraw(const std::string& name, const std::string& port, const std::string& id, const std::string& descriptor) const {
    const std::string hid = fmt::format("/sys/devices/usb1/{0}/{0}:1.0/{1}", port, name);
    write(hid + "/uevent", "DRIVER=hid-generic\nHID_ID=" + id + "\nHID_NAME=Thing\nHID_UNIQ=SN" + port + "\n");
    write(hid + "/report_descriptor", descriptor);
    link(hid + "/driver", "../../../../../bus/hid/drivers/hid-generic");
    make_folder(hid + "/hidraw/" + name);
    link(hid + "/hidraw/" + name + "/device", "../..");
    link("/sys/class/hidraw/" + name, fmt::format("../../devices/usb1/{0}/{0}:1.0/{1}/hidraw/{1}", port, name));
    write("/dev/" + name, "", 0660);
  }
  void write_devices() const {
    write_usb("1-1", "1234", "0006", "WoodenHaptics", "usbhid");
    write_hidraw("hidraw0", "1-1", "0003:00001234:00000006", std::string("\x06\x00\xff\x09\x01\xa1\x01\xc0", 8));
    write_usb("1-2", "256f", "c635", "SpaceMouse Compact", "usbhid");
    write_hidraw("hidraw1", "1-2", "0003:0000256F:0000C635", std::string("\x05\x01\x09\x08\xa1\x01\xc0", 7));
    write_usb("1-3", "2988", "0302", "Touch", "cdc_acm");
    link("/sys/devices/usb1/1-3/1-3:1.0/tty/ttyACM0/device", "../..");
    link("/sys/class/tty/ttyACM0", "../../devices/usb1/1-3/1-3:1.0/tty/ttyACM0");
    write("/dev/ttyACM0", "", 0660);
    write(
        "/usr/lib/udev/rules.d/70-hapton.rules",
        "# Devices\n"
        "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"1234\", ATTRS{idProduct}==\"0006\", TAG+=\"uaccess\", GROUP=\"plugdev\", MODE=\"0660\"\n"
        "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\", GROUP=\"plugdev\", MODE=\"0660\"\n"
        "SUBSYSTEM==\"tty\", ATTRS{idVendor}==\"2988\", ENV{ID_MM_DEVICE_IGNORE}=\"1\", TAG+=\"uaccess\", \\\n"
        "  GROUP=\"plugdev\", MODE=\"0660\"\n");
    run_program("301", "ModemManager");
  }

  void write_network() const {
    hold_port("udp", 4950, "77", "io_node");
    write("/etc/ufw/ufw.conf", "ENABLED=no\n");
    write("/etc/security/limits.d/hapton.conf", "@hapton - rtprio 90\n");
  }

  ScratchFolder scratch_;
};

}  // namespace hapton::doctor
