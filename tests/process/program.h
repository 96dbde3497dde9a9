#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hapton::process {

using Seconds = std::chrono::duration<double>;

// How long a test waits for what must come; only a program that hangs takes so long. Under a sanitizer one may be twenty times as slow.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr Seconds kPatience = Seconds(150);
#else
constexpr Seconds kPatience = Seconds(30);
#endif

// How a program ended.
struct Ended {
  int exit_code = -1;  // 128 + n when signal n ended it
  std::string out;
  std::string err;
};

// One of our programs, running. If it still runs when this object is destroyed, it is killed.
class Program {
 public:
  // Starts build/.../bin/NAME, or NAME itself if it is an absolute path, with its output going to files in folder (NAME.<n>.out,
  // NAME.<n>.err). display: an X display; empty: none. The user's shared key is also kept in folder, in hapton/master.
  Program(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const std::string& display = "");
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  bool is_running();
  pid_t pid() const { return pid_; }
  void send_signal(int signal);
  // How it ended; none: it still runs after this time.
  std::optional<Ended> wait(Seconds at_most);
  // Ends it at once, as a crash would.
  void kill();
  // Its output so far.
  std::string out() const;
  std::string err() const;

 private:
  void collect(bool block);

  std::filesystem::path out_path_;
  std::filesystem::path err_path_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

// Runs a program to its end; none: it was still running after at_most, and was killed.
std::optional<Ended> run(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                         Seconds at_most = kPatience);

// A virtual X display of its own, as long as this object lives.
class VirtualDisplay {
 public:
  VirtualDisplay();
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;
  const std::string& name() const { return name_; }

 private:
  pid_t pid_ = -1;
  std::string name_;
};

// A UDP port of 127.0.0.1 that is free at the moment.
std::string find_free_port();

// Occupies a UDP port of 127.0.0.1 as long as this object lives.
class TakenPort {
 public:
  TakenPort();
  ~TakenPort();
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;
  std::string port() const { return std::to_string(port_); }

 private:
  int socket_ = -1;
  int port_ = 0;
};

// A fresh folder for one test, named after it; kept when the test failed.
class TestFolder {
 public:
  TestFolder();
  ~TestFolder();
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string read_text(const std::filesystem::path& path);

}  // namespace hapton::process
