#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/math/types.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// A menu that hangs in the workspace, operated by the stylus: the entry at the tip is lit, and a press of any button of the stylus chooses
// it. Frames: W, and M, that of the panel: origin in its middle, x right, y up, z towards the viewer. Metres. RT: no.
class TouchMenu {
 public:
  enum class Entry : std::uint8_t { off, draw, measure, undo, redo, save, export_work, close };
  static constexpr std::array kEntries = {Entry::off,  Entry::draw, Entry::measure,     Entry::undo,
                                          Entry::redo, Entry::save, Entry::export_work, Entry::close};
  static std::string_view label(Entry entry);

  // Size of an entry: that of a finger tip, whatever the size of the scene, because the device's workspace has a fixed size.
  static constexpr double kEntryHeightM = 0.012;
  static constexpr double kWidthM = 0.060;
  static constexpr double kHeightM = kEntryHeightM * kEntries.size();
  // Largest distance of the tip before or behind the panel at which an entry is lit. Large, because the stylus does not feel the panel.
  static constexpr double kReachM = 2.0 * kEntryHeightM;

  // Hangs the menu up parallel to the screen, through the workspace's centre p_WC, as far to the right and then up as the device reaches.
  void open(const StereoScreen& screen, const Vec3& p_WC);
  void close() { X_WM_.reset(); }
  bool is_open() const { return X_WM_.has_value(); }
  // Pre: is_open().
  const Pose& pose() const { return *X_WM_; }

  // Call it with each state of the probe, in order: where the tip is drawn, and the buttons. Returns the entry that was chosen, if any.
  std::optional<Entry> receive(const Vec3& p_WP, std::uint32_t buttons);
  // The lit entry.
  std::optional<Entry> lit() const { return lit_; }
  // Chooses the lit entry, if there is one: a key in place of a button.
  std::optional<Entry> choose() const { return is_open() ? lit_ : std::nullopt; }

  // Where a ray from the eye p_WE through p_W meets the panel; none: it does not, or the menu is closed.
  std::optional<Vec3> find_ray_point(const Vec3& p_WE, const Vec3& p_W) const;

 private:
  std::optional<Entry> find_entry(const Vec3& p_M) const;

  std::optional<Pose> X_WM_;
  std::optional<Entry> lit_;
  std::uint32_t last_buttons_ = ~0U;
};

// The middle of an entry, frame M.
Vec3 place_entry(TouchMenu::Entry entry);

}  // namespace hapton
