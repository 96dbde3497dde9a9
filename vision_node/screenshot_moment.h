#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// When the picture of --screenshot is taken: at a contact that has lasted long enough to be drawn well, a number of seconds after the
// start, or at the exit; if neither contact nor time has come by then, at the exit, too. Times: ns since the start. RT: no.
class ScreenshotMoment {
 public:
  // "contact", "exit" or seconds. Error: anything else.
  static Result<ScreenshotMoment> parse(std::string_view text);

  // Call it for every frame that is drawn. True once, for the frame to keep.
  bool take_now(std::int64_t since_start_ns, bool contact);

  bool taken() const { return is_taken_; }
  // True: no contact lasted long enough, so the picture taken at the exit is not the one that was wanted.
  bool missed_contact() const { return kind_ == Kind::contact && !is_taken_; }

 private:
  enum class Kind { contact, exit, time };
  Kind kind_ = Kind::contact;
  std::int64_t at_ns_ = 0;
  std::int64_t contact_since_ns_ = -1;
  bool is_taken_ = false;
};

}  // namespace hapton
