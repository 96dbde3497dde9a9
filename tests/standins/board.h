#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <new>
#include <string>

// Shared memory between a test and the stand-in of a vendor's library, in one process or in two: a file, whose path the library finds in
// HAPTON_STANDIN_BOARD. The test sets what the hardware does and reads what was done to it.
namespace hapton::standin {

constexpr const char* kBoardVariable = "HAPTON_STANDIN_BOARD";
constexpr const char* kSecondBoardVariable = "HAPTON_STANDIN_SECOND_BOARD";  // path of the board of a second device of the same library

using Vector = std::array<std::atomic<double>, 3>;

struct Board {
  // Set by the test.
  std::atomic<int> is_plugged{1};
  std::atomic<int> calibration{0};           // 0 good, 1 needs update, 2 needs a person
  std::atomic<int> calibration_style{4};     // HD: 1 encoder reset, 2 auto, 4 inkwell, or several
  std::atomic<int> updates_until_good{1};    // the calibration is good after this many updates; 0: never
  std::atomic<unsigned> error_each_tick{0};  // HD: reported after each frame
  std::atomic<unsigned> error_once{0};       // HD: reported after the next frame
  std::atomic<int> known_name{0};            // HD: its name: 0 "Default Device", 1 "Default PHANToM", 2 only a null pointer, 3 "Left Hand"
  std::atomic<int> is_another{0};            // HD: not 0: another unit of the same model, with another serial number
  std::atomic<unsigned> endless_error{0};    // HD: not 0: every call of hdGetError returns it
  std::atomic<int> has_texts{1};             // HD: not 0: it reports model, serial number and firmware
  std::atomic<unsigned> open_error{0};       // HD: not 0: opening it fails with this error, plugged in or not
  std::atomic<int> errors_a_refusal{1};      // HD: how many errors each failed opening reports
  std::atomic<double> motor_temperature{0.2};
  std::atomic<int> slow_us{0};           // a delay added to each tick; DHD: to each call that transfers data
  std::atomic<int> stands_still{0};      // HD: not 0: the scheduler calls nothing
  std::atomic<int> force_off_cause{0};   // DHD: not 0: the firmware has switched the force off
  std::atomic<int> system_type{33};      // DHD: the type of the device
  std::atomic<int> result{0};            // DHD: result of every call that transfers data: 0 success, 1 time guard, 2 saturated
  std::atomic<int> failing_call{0};      // DHD: the call that fails: 1 orientation, 2 force, 3 status; 0: none
  std::atomic<int> serial{42};           // DHD: below 0: the device has no serial number
  std::atomic<int> has_power{1};         // DHD: as its status says
  std::atomic<int> is_connected{1};      // DHD: as its status says while it is plugged in
  std::atomic<int> claims_success{0};    // DHD: not 0: calibration by motors reports success even if it failed
  std::atomic<double> frame_scale{1.0};  // DHD: factor of the orientation matrix; not 1: the matrix is not a rotation
  std::atomic<int> buttons{0};
  std::atomic<int> output_dof{3};
  std::atomic<double> max_force_n{3.3};
  std::atomic<double> continuous_force_n{0.88};  // HD
  std::atomic<double> box_low_mm{-80.0};         // HD: lower end of the workspace along x
  std::atomic<double> max_stiffness{1.26};       // HD: N/mm
  std::atomic<int> follows_hand{1};              // 0: the point is at the hand; else it is a mass on the hand's spring
  Vector hand_m{};                               // device axes
  Vector turn_rad{};                             // angles of the stylus about x, then y, then z

  // Written by the stand-in. Forces are as Hapton set them, in the units and axes of the device.
  Vector position_m{};
  Vector force{};
  Vector torque{};
  std::atomic<double> largest_force{0};
  std::atomic<double> largest_step{0};  // largest change of the force from one frame to the next
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::uint64_t> pushed_ticks{0};    // number of frames with a force above zero
  std::atomic<std::uint64_t> pushed_unasked{0};  // the same, but only while not calibrated
  std::atomic<std::uint64_t> wrong_calls{0};     // calls outside a frame, from another thread, or with a handle that is not open
  std::atomic<std::uint64_t> calibration_updates{0};
  std::atomic<int> last_update_style{0};
  std::atomic<std::uint64_t> opened{0};
  std::atomic<std::uint64_t> refused{0};  // HD: openings that failed
  std::atomic<std::uint64_t> closed{0};
  std::atomic<int> enabled{0};  // HD: bit n for capability 0x4000 + n; DHD: forces are on
  std::atomic<int> watchdog{0};
  std::atomic<int> is_running{0};
  std::atomic<int> moved_by_itself{0};  // DHD: not 0: its motors moved it to calibrate it
  std::atomic<int> kept_forces{-1};     // DHD: the forces after drdStop: 1 left on, 0 switched off; -1: drdStop was not called
};
static_assert(std::atomic<double>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);

// A board in a file. The test creates the file, the stand-in maps it into its memory.
class BoardFile {
 public:
  // For the test: creates the file and puts its path into the environment, for all programs that are started from now on.
  explicit BoardFile(const std::filesystem::path& path, const char* variable = kBoardVariable)
      : BoardFile(path.c_str(), O_RDWR | O_CREAT | O_TRUNC) {
    new (board_) Board;
    ::setenv(variable, path.c_str(), 1);
  }
  // For the stand-in: the board whose file the environment names, or else a board of its own.
  static Board& of_environment(const char* variable = kBoardVariable) {
    static Board alone;
    // Earlier boards stay mapped, because another thread may still read one.
    static std::map<std::string, BoardFile> mapped;
    const char* path = std::getenv(variable);
    if (path == nullptr) return alone;
    return *mapped.try_emplace(path, path, O_RDWR).first->second.board_;
  }

  BoardFile(const char* path, int flags) {
    const int file = ::open(path, flags | O_CLOEXEC, 0600);
    if (file < 0 || ::ftruncate(file, sizeof(Board)) != 0) std::abort();
    void* const memory = ::mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) std::abort();
    board_ = static_cast<Board*>(memory);
  }
  ~BoardFile() { ::munmap(static_cast<void*>(board_), sizeof(Board)); }
  BoardFile(const BoardFile&) = delete;
  BoardFile& operator=(const BoardFile&) = delete;

  Board* operator->() const { return board_; }
  Board& operator*() const { return *board_; }

 private:
  Board* board_;
};

}  // namespace hapton::standin
