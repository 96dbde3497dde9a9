// A healthy machine, and faults seeded into it, one at a time: the doctor must name each fault and say what fixes it.
#include "tools/doctor/diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/doctor/fake_machine.h"

namespace hapton::doctor {
namespace {

using ::testing::AllOf;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// All findings that a person would have to fix.
std::vector<Finding> complaints_of(const Diagnosis& diagnosis) {
  std::vector<Finding> complaints;
  for (const Section& section : diagnosis.sections) {
    for (const Finding& finding : section.findings) {
      if (finding.verdict == Verdict::warning || finding.verdict == Verdict::problem) complaints.push_back(finding);
    }
  }
  return complaints;
}

struct Fault {
  std::string name;
  std::function<void(FakeMachine&)> seed;
  Verdict verdict = Verdict::problem;
  std::string observation;
  std::string remedy;
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

void set_library_reply(FakeMachine& machine, const LibraryReply& reply) {
  machine.replies.library = [reply](std::string_view name) {
    return name == "OpenHaptics" ? reply : LibraryReply{{}, {{"libdrd.so", FakeMachine::kLibdrdError, "install it"}}, {}};
  };
}

void set_hub_reply(FakeMachine& machine, const std::string& notes) {
  machine.replies.hub = [notes] { return HubReply{{}, "{\"notes\": " + notes + "}"}; };
}

void write_key(FakeMachine& machine, std::size_t bytes, mode_t mode) {
  machine.set_user(::getuid(), machine.user_groups(), "0000000000804000");  // SYS_NICE and IPC_LOCK
  machine.write("/home/ada/.config/hapton/master", std::string(bytes, 'k'), mode);
}

const std::vector<Fault> kFaults = {
    {"NodeClosedAndNoRule",
     [](FakeMachine& m) {
       m.set_mode("/dev/hidraw0", 0600);
       m.write("/usr/lib/udev/rules.d/70-hapton.rules",
               "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"\nSUBSYSTEM==\"tty\", ATTRS{idVendor}==\"2988\", "
               "ENV{ID_MM_DEVICE_IGNORE}=\"1\", TAG+=\"uaccess\"\n");
     },
     Verdict::problem, "/dev/hidraw0 is closed to ada: no udev rule names it",
     "echo 'SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"1234\", ATTRS{idProduct}==\"0006\", TAG+=\"uaccess\", GROUP=\"plugdev\", "
     "MODE=\"0660\"' | sudo tee -a /etc/udev/rules.d/70-hapton-local.rules && sudo udevadm control --reload"},
    {"RuleNotApplied", [](FakeMachine& m) { m.set_mode("/dev/hidraw0", 0600); }, Verdict::problem,
     "the rule 70-hapton.rules has not been applied to it", "sudo udevadm trigger --action=change --subsystem-match=hidraw"},
    {"NotInTheGroup",
     [](FakeMachine& m) {
       m.set_user(m.another_uid(), "7001");
       m.write("/etc/group", fmt::format("plugdev:x:{}:\nhapton:x:7001:ada\n", m.own_group()));
       m.set_mode("/dev/ttyACM0", 0666);
       m.set_mode("/dev/hidraw1", 0666);
       m.set_mode("/dev/cpu_dma_latency", 0666);
     },
     Verdict::problem, "/dev/hidraw0 is closed to ada: it is for the group plugdev",
     "sudo adduser ada plugdev   # then log out and in again"},
    {"SessionOlderThanTheGroup",
     [](FakeMachine& m) {
       m.set_user(m.another_uid(), "7001");
       m.set_mode("/dev/ttyACM0", 0666);
       m.set_mode("/dev/hidraw1", 0666);
       m.set_mode("/dev/cpu_dma_latency", 0666);
     },
     Verdict::problem, "ada is in the group plugdev since this session began", "log out and in again, or: newgrp plugdev"},
    {"RuleWithCapitalDigits",
     [](FakeMachine& m) {
       m.set_mode("/dev/hidraw1", 0600);
       m.write("/usr/lib/udev/rules.d/70-hapton.rules",
               "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256F\", TAG+=\"uaccess\"\nSUBSYSTEM==\"tty\", ATTRS{idVendor}==\"2988\", "
               "ENV{ID_MM_DEVICE_IGNORE}=\"1\", TAG+=\"uaccess\"\n");
     },
     Verdict::problem, "70-hapton.rules has capital hexadecimal digits", "sudo sed -i -E"},
    {"RuleTooLate",
     [](FakeMachine& m) {
       m.set_mode("/dev/hidraw1", 0600);
       m.write("/usr/lib/udev/rules.d/70-hapton.rules",
               "SUBSYSTEM==\"tty\", ATTRS{idVendor}==\"2988\", ENV{ID_MM_DEVICE_IGNORE}=\"1\", TAG+=\"uaccess\"\n");
       m.write("/etc/udev/rules.d/99-mouse.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"\n");
     },
     Verdict::problem, "/etc/udev/rules.d/99-mouse.rules sorts after 73-seat-late.rules",
     "sudo mv /etc/udev/rules.d/99-mouse.rules /etc/udev/rules.d/70-mouse.rules"},
    {"NodeMissing", [](FakeMachine& m) { m.remove("/dev/hidraw0"); }, Verdict::problem,
     "the kernel has it as /dev/hidraw0, but there is no such file", "docker run --device=/dev/hidraw0"},
    {"NoDriver",
     [](FakeMachine& m) {
       m.remove("/sys/class/hidraw/hidraw0");
       m.remove("/sys/devices/usb1/1-1/1-1:1.0/driver");
     },
     Verdict::problem, "no kernel driver has taken it", "sudo modprobe usbhid && sudo modprobe hid-generic"},
    {"UsbSleep", [](FakeMachine& m) { m.write("/sys/devices/usb1/1-1/power/control", "auto\n"); }, Verdict::warning, "USB autosuspend",
     "echo on | sudo tee /sys/devices/usb1/1-1/power/control"},
    {"ModemManager",
     [](FakeMachine& m) {
       m.write("/usr/lib/udev/rules.d/70-hapton.rules",
               "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"1234\", TAG+=\"uaccess\"\nSUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", "
               "TAG+=\"uaccess\"\nSUBSYSTEM==\"tty\", ATTRS{idVendor}==\"2988\", TAG+=\"uaccess\"\n");
     },
     Verdict::problem, "talks to /dev/ttyACM0", "ENV{ID_MM_DEVICE_IGNORE}=\"1\"' | sudo tee -a /etc/udev/rules.d/70-hapton-local.rules"},
    {"Spacenavd", [](FakeMachine& m) { m.run_program("302", "spacenavd"); }, Verdict::warning, "runs beside Hapton",
     "sudo systemctl stop spacenavd"},
    {"LibraryNeedsAnother",
     [](FakeMachine& m) {
       set_library_reply(m, {{},
                             {{"libHD.so", "libncurses.so.5: cannot open shared object file: No such file or directory",
                               "libHD.so is there, but needs libncurses.so.5, which is not: install libncurses5"}},
                             {}});
     },
     Verdict::problem, "libncurses.so.5: cannot open shared object file: No such file or directory", "install libncurses5"},
    {"LibraryMissing",
     [](FakeMachine& m) {
       set_library_reply(m, {{}, {{"libHD.so", "libHD.so: cannot open shared object file: No such file or directory", "install it"}}, {}});
     },
     Verdict::problem, "3D Systems Touch (USB) needs it, and it is not here: libHD.so: cannot open", "OpenHaptics for Linux"},
    {"LibraryCrashes",
     [](FakeMachine& m) {
       set_library_reply(m, {{}, {}, "it ended the process with signal 11 (Segmentation fault)"});
     },
     Verdict::problem, "signal 11", "reinstall it"},
    {"NotCalibrated",
     [](FakeMachine& m) { set_hub_reply(m, R"({"device": "openhaptics", "device_state": "calibrating", "device_calibrated": "no"})"); },
     Verdict::problem, "not calibrated", "put the stylus into its inkwell"},
    {"Unplugged", [](FakeMachine& m) { set_hub_reply(m, R"({"device": "wooden-haptics", "device_state": "away"})"); }, Verdict::problem,
     "wooden-haptics: unplugged or not responding", "check its cable and power"},
    {"HotMotors",
     [](FakeMachine& m) { set_hub_reply(m, R"({"device": "openhaptics", "device_state": "ready", "motor_temperature": "0.93"})"); },
     Verdict::warning, "at 93 % of their temperature limit", "let it rest"},
    {"HubWithoutRights",
     [](FakeMachine& m) {
       set_hub_reply(m,
                     R"j({"device": "simulated", "device_state": "ready",
                "realtime": "real time: priority SCHED_FIFO 80: denied (Operation not permitted; x)"})j");
     },
     Verdict::warning, "SCHED_FIFO 80: denied (Operation not permitted", "hapton doctor --only rights"},
    {"HubWithAnotherKey", [](FakeMachine& m) { m.replies.hub = [] {
                                                 return HubReply{"nobody replies", {}};
                                               }; }, Verdict::warning,
     "127.0.0.1:4950: nobody replies", "hapton doctor --key FILE"},
    {"NoPriority",
     [](FakeMachine& m) {
       m.set_limits("0", "unlimited");
       m.remove("/etc/security/limits.d/hapton.conf");
     },
     Verdict::problem, "at most 0 for ada, and io_node requests 80",
     "printf '@hapton - rtprio 90\\n@hapton - memlock unlimited\\n' | sudo tee /etc/security/limits.d/hapton.conf"},
    {"NotInTheRealTimeGroup",
     [](FakeMachine& m) {
       m.set_limits("0", "unlimited");
       m.set_user(m.another_uid(), fmt::format("{}", m.own_group()));
       m.write("/etc/group", fmt::format("plugdev:x:{}:ada\nhapton:x:7001:\n", m.own_group()));
     },
     Verdict::problem, "at most 0 for ada", "sudo adduser ada hapton   # then log out and in again"},
    {"LittleLockedMemory", [](FakeMachine& m) { m.set_limits("90", "8388608"); }, Verdict::problem, "at most 8 MiB for ada",
     "log out and in again: the group hapton has the rights"},
    {"ThrottledEarly", [](FakeMachine& m) { m.write("/proc/sys/kernel/sched_rt_runtime_us", "100000\n"); }, Verdict::problem,
     "real-time threads get 10 % of each CPU", "sudo sysctl -w kernel.sched_rt_runtime_us=950000"},
    {"NeverThrottled", [](FakeMachine& m) { m.write("/proc/sys/kernel/sched_rt_runtime_us", "-1\n"); }, Verdict::warning,
     "a loop that runs wild would take its CPU for good", "sudo sysctl -w kernel.sched_rt_runtime_us=950000"},
    {"ControlGroupWithoutRealTime",
     [](FakeMachine& m) {
       m.write("/proc/self/cgroup", "9:memory:/user\n4:cpu,cpuacct:/user/ada\n0::/user\n");
       m.write("/sys/fs/cgroup/cpu,cpuacct/user/ada/cpu.rt_runtime_us", "0\n");
     },
     Verdict::problem, "/sys/fs/cgroup/cpu,cpuacct/user/ada/cpu.rt_runtime_us is 0",
     "echo 950000 | sudo tee /sys/fs/cgroup/cpu,cpuacct/user/ada/cpu.rt_runtime_us"},
    {"DeepSleep", [](FakeMachine& m) { m.set_mode("/dev/cpu_dma_latency", 0600); }, Verdict::problem,
     "the deepest state in use is C10, 890 us to wake up, and /dev/cpu_dma_latency is closed to ada", "/etc/udev/rules.d/60-hapton.rules"},
    {"SlowGovernor", [](FakeMachine& m) { m.write("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n"); },
     Verdict::problem, "governor powersave (cpu1, acpi-cpufreq): the CPU stays at its lowest frequency",
     "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"},
    {"SlowGovernorBesideALateOne",
     [](FakeMachine& m) {
       m.write("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "ondemand\n");
       m.write("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
     },
     Verdict::problem, "governor powersave (cpu1, acpi-cpufreq): the CPU stays at its lowest frequency",
     "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"},
    {"LateGovernor", [](FakeMachine& m) { m.write("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "schedutil\n"); },
     Verdict::warning, "governor schedutil", "echo performance | sudo tee"},
    {"OneCpu", [](FakeMachine& m) { m.write("/sys/devices/system/cpu/online", "0\n"); }, Verdict::warning, "one: the loop and every other",
     "give the machine a second CPU"},
    {"Hypervisor", [](FakeMachine& m) { m.write("/proc/cpuinfo", "flags\t\t: fpu hypervisor avx2\n"); }, Verdict::warning,
     "a hypervisor shares out the CPUs", "bare machine"},
    {"SlowClock", [](FakeMachine& m) { m.write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"); },
     Verdict::problem, "hpet: every reading takes a microsecond",
     "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource"},
    {"KernelNotPreemptible",
     [](FakeMachine& m) {
       m.remove("/sys/kernel/realtime");
       m.write("/proc/version", "Linux version 5.4.0 (x) #1 SMP\n");
     },
     Verdict::warning, "5.4.0 is not preemptible", "sudo apt-get install linux-image-rt-amd64"},
    {"PortTaken",
     [](FakeMachine& m) {
       m.hold_port("udp6", 4950, "88", "python3");
       m.remove("/proc/77");
       m.replies.hub = {};
     },
     Verdict::problem, "python3 (process 88) has it, so io_node cannot",
     "kill 88   # or give the hub another one: io_node --bind 127.0.0.1:4951"},
    {"VrpnPortTaken", [](FakeMachine& m) { m.hold_port("tcp", 3883, "89", "vrpn_server"); }, Verdict::warning,
     "vrpn_server (process 89) has it", "kill 89"},
    {"KeyOpenToOthers", [](FakeMachine& m) { write_key(m, 48, 0644); }, Verdict::problem, "is open to other users (mode 0644)",
     "chmod 600 /home/ada/.config/hapton/master"},
    {"KeyOpenToItsGroup", [](FakeMachine& m) { write_key(m, 48, 0640); }, Verdict::problem, "is open to other users (mode 0640)",
     "chmod 600 /home/ada/.config/hapton/master"},
    {"KeyOfWrongLength", [](FakeMachine& m) { write_key(m, 31, 0600); }, Verdict::problem, "has 31 bytes, but a key file has 48",
     "hapton keygen /home/ada/.config/hapton/master"},
    {"KeyOfAnOlderVersion", [](FakeMachine& m) { write_key(m, 32, 0600); }, Verdict::problem, "is a key of an older Hapton",
     "hapton keygen /home/ada/.config/hapton/master"},
    {"KeyOfSomeoneElse", [](FakeMachine& m) { m.write("/home/ada/.config/hapton/master", std::string(48, 'k'), 0600); }, Verdict::problem,
     "belongs to user", "sudo chown ada /home/ada/.config/hapton/master"},
    {"KeyNotThere", [](FakeMachine& m) { m.settings.key_file = "/home/ada/mine.key"; }, Verdict::problem, "/home/ada/mine.key is not there",
     "hapton keygen /home/ada/mine.key"},
    {"ServiceWithoutKey",
     [](FakeMachine& m) {
       m.link("/etc/systemd/system/multi-user.target.wants/hapton-io.service", "/usr/lib/systemd/system/hapton-io.service");
     },
     Verdict::problem, "it does not start", "sudo hapton keygen /etc/hapton/key"},
    {"FirewallClosed",
     [](FakeMachine& m) {
       m.write("/etc/ufw/ufw.conf", "# x\nENABLED=yes\n");
       m.write("/etc/ufw/user.rules", "*filter\nCOMMIT\n");
     },
     Verdict::warning, "has no rule for port 4950", "sudo ufw allow from"},
    {"FirewallOpenForOtherPorts",
     [](FakeMachine& m) {
       m.write("/etc/ufw/ufw.conf", "ENABLED=yes\n");
       m.write("/etc/ufw/user.rules",
               "-A ufw-user-input -p udp --dport 49500 -j ACCEPT\n-A ufw-user-input -p udp --dport 14950 -j ACCEPT\n");
     },
     Verdict::warning, "has no rule for port 4950", "sudo ufw allow from"},
    {"FirewallWithThePortInAComment",
     [](FakeMachine& m) {
       m.write("/etc/ufw/ufw.conf", "ENABLED=yes\n");
       m.write("/etc/ufw/user.rules", "*filter\n# -A ufw-user-input -p udp --dport 4950 -j ACCEPT\nCOMMIT\n");
     },
     Verdict::warning, "has no rule for port 4950", "sudo ufw allow from"},
    {"NftablesWithThePortInAComment",
     [](FakeMachine& m) {
       m.write("/etc/nftables.conf",
               "chain input {\n  type filter hook input priority 0; policy drop;\n"
               "  log prefix \"#1 \" tcp dport 22 accept  # not 4950\n}\n");
     },
     Verdict::warning, "has no rule for port 4950", "sudo nft add rule"},
    {"NoDisplay", [](FakeMachine& m) { m.set_environment(std::string("HOME=/home/ada\0", 15)); }, Verdict::warning, "DISPLAY is not set",
     "xvfb-run -a"},
    {"DisplayRefuses",
     [](FakeMachine& m) { m.replies.display = [] {
                            return DisplayReply{"no connection to DISPLAY=:0", {}, {}, false, false};
                          }; },
     Verdict::problem, ":0: no connection", "a desktop's own terminal"},
    {"DrawnByTheCpu",
     [](FakeMachine& m) { m.replies.display = [] {
                            return DisplayReply{{}, "llvmpipe (LLVM 15.0.6, 256 bits)", "4.5", true, true};
                          }; },
     Verdict::warning, "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 at :0: the CPU draws", "install the driver of the graphics card"},
};

class SeededFaults : public testing::TestWithParam<Fault> {};

TEST_P(SeededFaults, AreNamedAndFixed) {
  FakeMachine machine;
  GetParam().seed(machine);
  const Diagnosis diagnosis = diagnose(machine.make());
  const auto is_reported = AllOf(Field("verdict", &Finding::verdict, GetParam().verdict),
                                 Field("observation", &Finding::observation, HasSubstr(GetParam().observation)),
                                 Field("remedy", &Finding::remedy, HasSubstr(GetParam().remedy)));
  // The fault is reported, and nothing else: it must not hide among false alarms.
  EXPECT_THAT(complaints_of(diagnosis), testing::ElementsAre(is_reported)) << to_text(diagnosis, false);
  EXPECT_THAT(to_text(diagnosis, false), AllOf(HasSubstr(GetParam().observation), HasSubstr("fix: "), HasSubstr(GetParam().remedy)));
  EXPECT_EQ(diagnosis.is_fit(), GetParam().verdict != Verdict::problem);
}

INSTANTIATE_TEST_SUITE_P(Doctor, SeededFaults, testing::ValuesIn(kFaults), [](const auto& fault) { return fault.param.name; });

TEST(Diagnosis, FindsNothingToFixOnAHealthyMachine) {
  const FakeMachine machine;
  const Diagnosis diagnosis = diagnose(machine.make());
  EXPECT_THAT(complaints_of(diagnosis), IsEmpty()) << to_text(diagnosis, false);
  EXPECT_TRUE(diagnosis.is_fit());
  const std::string text = to_text(diagnosis, false);
  for (const char* lines :
       {"WoodenHaptics 1234:0006 SN1-1: /dev/hidraw0 (hid-generic), open to ada by rule 70-hapton.rules; io_node --device wooden-haptics",
        "/dev/ttyACM0 (cdc_acm)", "SpaceMouse Compact 256f:c635", "libHD.so.3.4 loads", "Touch, firmware 192, calibrated",
        "--stereo crystal_eyes", "obstacles to 1 kHz: none\nno problem, 0 warnings\n"}) {
    EXPECT_THAT(text, HasSubstr(lines));
  }
}

TEST(Diagnosis, CountsTheCpusOfAList) {
  FakeMachine machine;
  machine.write("/sys/devices/system/cpu/online", "0-3,5,8-9\n");
  machine.write("/sys/devices/system/cpu/isolated", "2-3\n");
  const std::string text = to_text(diagnose(machine.make(), std::vector<std::string>{"cpus"}), false);
  EXPECT_THAT(text, HasSubstr("7, of which 2-3 are isolated for real time: io_node --cpu 2"));
}

TEST(Diagnosis, TheVersionOrTheFileOfTheKernelShowsThatItIsForRealTime) {
  FakeMachine machine;
  const auto text_of_kernel = [&](const char* version, bool has_file) {
    machine.write("/proc/version", fmt::format("Linux version {} Debian\n", version));
    machine.remove("/sys/kernel/realtime");
    if (has_file) machine.write("/sys/kernel/realtime", "1\n");
    const Diagnosis diagnosis = diagnose(machine.make());
    EXPECT_THAT(complaints_of(diagnosis), IsEmpty());
    return to_text(diagnosis, false);
  };
  EXPECT_THAT(text_of_kernel("6.1.0 (x) #1 SMP PREEMPT_RT", false), HasSubstr("6.1.0, PREEMPT_RT"));
  EXPECT_THAT(text_of_kernel("4.4.0 (x) #1 SMP PREEMPT RT", true), HasSubstr("4.4.0, PREEMPT_RT"));
  EXPECT_THAT(text_of_kernel("6.1.0 (x) #1 SMP PREEMPT_DYNAMIC", false), HasSubstr("6.1.0, preemptible; linux-image-rt-amd64"));
}

TEST(Diagnosis, AFirewallThatLetsThePortThroughIsGood) {
  FakeMachine machine;
  machine.write("/etc/ufw/ufw.conf", "ENABLED=yes\n");
  machine.write("/etc/ufw/user.rules",
                "-A ufw-user-input -p udp --dport 14950 -j ACCEPT\n-A ufw-user-input -p udp --dport 4950 -j ACCEPT\n");
  const Diagnosis diagnosis = diagnose(machine.make());
  EXPECT_THAT(complaints_of(diagnosis), IsEmpty()) << to_text(diagnosis, false);
  EXPECT_THAT(to_text(diagnosis, false), HasSubstr("lets port 4950 through"));
}

TEST(Diagnosis, ARuleOfNftablesAfterAQuotedNumberSignCounts) {
  FakeMachine machine;
  machine.write("/etc/nftables.conf", "# policy drop\n");
  EXPECT_THAT(to_text(diagnose(machine.make()), false), HasSubstr("none found in ufw, firewalld or /etc/nftables.conf"));
  machine.write("/etc/nftables.conf", "type filter hook input priority 0; policy drop;\nlog prefix \"#1 \" udp dport 4950 accept\n");
  EXPECT_THAT(to_text(diagnose(machine.make()), false), HasSubstr("lets port 4950 through"));
}

TEST(Diagnosis, APortOfFirewalldWithinACommentDoesNotCount) {
  FakeMachine machine;
  machine.run_program("88", "firewalld");
  const std::string commented = "<zone>\n<!-- <port port=\"4950\" protocol=\"udp\"/>\n-->\n<service name=\"ssh\"/>\n";
  machine.write("/etc/firewalld/zones/public.xml", commented + "</zone>\n");
  EXPECT_THAT(to_text(diagnose(machine.make()), false), HasSubstr("has no rule for port 4950"));
  machine.write("/etc/firewalld/zones/public.xml", commented + "<port port=\"4950\" protocol=\"udp\"/> <!-- hub --></zone>\n");
  EXPECT_THAT(to_text(diagnose(machine.make()), false), HasSubstr("lets port 4950 through"));
}

TEST(Diagnosis, ChecksOnlyWhatIsRequested) {
  const FakeMachine machine;
  const Diagnosis diagnosis = diagnose(machine.make(), std::vector<std::string>{"clock", "keys"});
  ASSERT_EQ(diagnosis.sections.size(), 2U);
  EXPECT_EQ(diagnosis.sections.front().name, "clock");
}

TEST(Diagnosis, IsJsonForPrograms) {
  FakeMachine machine;
  machine.write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  const auto json = nlohmann::json::parse(to_json(diagnose(machine.make(), std::vector<std::string>{"clock"})));
  EXPECT_EQ(json.at("schema"), "hapton.doctor/1");
  EXPECT_FALSE(json.at("build").get<std::string>().empty());
  EXPECT_EQ(json.at("fit"), false);
  EXPECT_EQ(json.at("problems"), 1);
  EXPECT_EQ(json.at("warnings"), 0);
  const auto& finding = json.at("checks").at(0).at("findings").at(0);
  EXPECT_EQ(finding.at("verdict"), "problem");
  EXPECT_THAT(finding.at("remedy").get<std::string>(), HasSubstr("echo tsc"));
}

TEST(Diagnosis, SaysWhatIsInTheWayOfOneKilohertz) {
  FakeMachine machine;
  machine.set_limits("0", "unlimited");
  machine.write("/proc/cpuinfo", "flags\t\t: hypervisor\n");
  const Diagnosis diagnosis = diagnose(machine.make());
  EXPECT_EQ(diagnosis.obstacles_to_1_khz(), (std::vector<std::string>{"real-time priority", "virtual machine"}));
  EXPECT_THAT(to_text(diagnosis, false), HasSubstr("obstacles to 1 kHz: real-time priority, virtual machine\n"));
  EXPECT_FALSE(diagnose(machine.make(), std::vector<std::string>{"rights"}).obstacles_to_1_khz());
}

TEST(Diagnosis, UsesColoursOnlyOnRequest) {
  const FakeMachine machine;
  const Diagnosis diagnosis = diagnose(machine.make(), std::vector<std::string>{"clock"});
  EXPECT_THAT(to_text(diagnosis, true), HasSubstr("\x1b["));
  EXPECT_THAT(to_text(diagnosis, false), testing::Not(HasSubstr("\x1b[")));
}

TEST(Diagnosis, SurvivesAMachineWithoutInformation) {
  const ScratchFolder empty;
  const Diagnosis diagnosis = diagnose(Machine(empty.path(), {}, {}));
  EXPECT_EQ(diagnosis.sections.size(), all_checks().size());
  for (const Finding& complaint : complaints_of(diagnosis)) EXPECT_FALSE(complaint.remedy.empty()) << complaint.subject;
}

TEST(Diagnosis, FindsHaptonHidByItsUsageWhateverTheMaker) {
  FakeMachine machine;
  machine.write("/sys/devices/usb1/1-1/1-1:1.0/hidraw0/uevent", "HID_ID=0003:0000CAFE:00004001\n");
  machine.write("/sys/devices/usb1/1-1/1-1:1.0/hidraw0/report_descriptor", std::string("\x06\x48\xff\x09\x01\xa1\x01\xc0", 8));
  machine.write("/sys/devices/usb1/1-1/idVendor", "cafe\n");
  machine.write("/sys/devices/usb1/1-1/idProduct", "4001\n");
  EXPECT_THAT(to_text(diagnose(machine.make(), std::vector<std::string>{"devices"}), false),
              HasSubstr("Hapton HID device cafe:4001: /dev/hidraw0 (hid-generic), open to ada; io_node --device hapton-hid"));
}

TEST(Diagnosis, NamesADeviceThatHaptonCannotDrive) {
  FakeMachine machine;
  machine.write("/sys/devices/usb1/1-1/idVendor", "16c0\n");
  machine.write("/sys/devices/usb1/1-1/idProduct", "0486\n");
  const Diagnosis diagnosis = diagnose(machine.make(), std::vector<std::string>{"devices"});
  EXPECT_THAT(complaints_of(diagnosis), IsEmpty());
  EXPECT_THAT(to_text(diagnosis, false), HasSubstr("Hapton cannot drive it"));
}

TEST(Diagnosis, SaysHowToLookWhenNothingIsPluggedIn) {
  FakeMachine machine;
  machine.remove("/sys/bus");
  machine.remove("/sys/class");
  const Diagnosis diagnosis = diagnose(machine.make(), std::vector<std::string>{"devices"});
  EXPECT_THAT(to_text(diagnosis, false), AllOf(HasSubstr("none is plugged in"), HasSubstr("lsusb")));
}

}  // namespace
}  // namespace hapton::doctor
