// A view draws for a headset, without a runtime: both eyes' pictures into textures, one of them into the window as well, and then only the
// window again.
#include "vision_node/headset_window.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/patience.h"
#include "tests/vision_node/made_views.h"
#include "tests/vision_node/xr/mock_views.h"

// Last, because it defines X's macros.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

constexpr PictureSize kEyePixels{500, 440};
const Vec3 kHeadsetMarker(0.03, 0.02, 0.01);
// The pose of the workspace in front of the eyes.
const Pose kX_LW(Eigen::Translation3d(0.0, -0.15, -0.5));

HeadsetEyes headset_eyes(int frame) {
  const auto eyes = mock_xr::eyes_at(frame);
  const auto look = [](const EyeInFrame& eye) {
    return look_through({kX_LW.inverse() * eye.X_FE, eye.fov}, {.plane_m = 0.5, .near_m = 0.02, .far_m = 2.0}, Vec3::UnitY());
  };
  return {kEyePixels, look(eyes[0]), look(eyes[1])};
}

// The pixel at which an eye sees a point, from the tangents of the eye's angles alone.
Vec2 project_into_eye(const EyeInFrame& eye, const Vec3& p_W) {
  const Vec3 p_E = eye.X_FE.inverse() * (kX_LW * p_W);
  const double l = std::tan(eye.fov.left_rad), r = std::tan(eye.fov.right_rad), u = std::tan(eye.fov.up_rad),
               d = std::tan(eye.fov.down_rad);
  return {(p_E.x() / -p_E.z() - l) / (r - l) * kEyePixels.width_px, (p_E.y() / -p_E.z() - d) / (u - d) * kEyePixels.height_px};
}

std::unique_ptr<StereoView> open_headset_view(bool is_mapped, int msaa = 0) {
  ViewSettings settings = plain_settings(StereoMode::openxr, 640, 360);
  settings.offscreen = !is_mapped;
  settings.msaa = msaa;
  return open_or_fail(settings, {{make_marker(kHeadsetMarker, 0.01), {1, 1, 1}}});
}

// A texture like those of an OpenXR runtime.
class EyeTexture {
 public:
  explicit EyeTexture(GLint format) {
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, format, kEyePixels.width_px, kEyePixels.height_px, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    glBindTexture(GL_TEXTURE_2D, 0);
  }
  ~EyeTexture() { glDeleteTextures(1, &name); }
  EyeTexture(const EyeTexture&) = delete;
  EyeTexture& operator=(const EyeTexture&) = delete;

  Picture read() const {
    Picture picture{kEyePixels, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(kEyePixels.width_px) * kEyePixels.height_px)};
    glBindTexture(GL_TEXTURE_2D, name);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glBindTexture(GL_TEXTURE_2D, 0);
    return picture;
  }

  GLuint name = 0;
};

void expect_both_eyes(StereoView& view, int frame, GLint format) {
  view.set_headset_eyes(headset_eyes(frame));
  ASSERT_TRUE(view.set_stereo(StereoMode::openxr));
  view.draw();
  view.make_current();
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const EyeTexture texture(format);
    view.copy_eye(eye, texture.name);
    const auto found = centroid(texture.read(), 0, 0, kEyePixels.width_px);
    ASSERT_TRUE(found) << "eye " << eye;
    EXPECT_LT((*found - project_into_eye(mock_xr::eyes_at(frame)[eye], kHeadsetMarker)).norm(), 0.5) << "eye " << eye << " frame " << frame;
  }
}

TEST(HeadsetWindow, EachEyesTextureShowsAMarkerWhereItsFrustumPutsIt) {
  for (const int msaa : {0, 4}) {
    auto view = open_headset_view(false, msaa);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->mode(), StereoMode::mono) << "until the headset shows something";
    for (const int frame : {0, 1, 5, 9}) expect_both_eyes(*view, frame, GL_SRGB8_ALPHA8);
    EXPECT_EQ(view->mode(), StereoMode::openxr);
    EXPECT_EQ(view->picture_size(), kEyePixels);
  }
}

TEST(HeadsetWindow, BytesGoIntoEveryTextureUnchanged) {
  auto view = open_headset_view(false);
  ASSERT_TRUE(view);
  view->set_headset_eyes(headset_eyes(3));
  ASSERT_TRUE(view->set_stereo(StereoMode::openxr));
  view->draw();
  const Picture both = view->read_picture();
  ASSERT_EQ(both.size, (PictureSize{2 * kEyePixels.width_px, kEyePixels.height_px}));
  view->make_current();
  for (const GLint format : {GL_SRGB8_ALPHA8, GL_RGBA8}) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const EyeTexture texture(format);
      view->copy_eye(eye, texture.name);
      const Picture one = texture.read();
      int differing = 0;
      for (int y = 0; y < kEyePixels.height_px; ++y) {
        for (int x = 0; x < kEyePixels.width_px; ++x) {
          differing += !std::equal(one.at(x, y), one.at(x, y) + 3, both.at(x + static_cast<int>(eye) * kEyePixels.width_px, y));
        }
      }
      EXPECT_EQ(differing, 0) << "eye " << eye;
    }
  }
}

TEST(HeadsetWindow, TheWindowAloneIsAsItWasOnceTheHeadsetIsGone) {
  for (const bool is_mapped : {false, true}) {
    auto view = open_headset_view(is_mapped);
    ASSERT_TRUE(view);
    view->draw();
    const Picture before = view->read_picture();
    for (int frame = 0; frame < 2; ++frame) expect_both_eyes(*view, frame, GL_RGBA8);
    ASSERT_TRUE(view->set_stereo(StereoMode::mono));
    view->draw();
    const Picture after = view->read_picture();
    EXPECT_EQ(after.size, (PictureSize{640, 360}));
    EXPECT_TRUE(after.rgb == before.rgb) << "mapped: " << is_mapped;
  }
}

class HeadsetMirror : public testing::Test {
 protected:
  void SetUp() override {
    view_ = open_headset_view(true);
    ASSERT_TRUE(view_);
    view_->draw();
    view_->poll_events();
    person_ = std::make_unique<Person>();
    ASSERT_TRUE(person_->has_window());
    draw_mirror();
  }
  void draw_mirror() {
    view_->set_headset_eyes(headset_eyes(2));
    ASSERT_TRUE(view_->set_stereo(StereoMode::openxr));
    view_->draw();
    view_->make_current();
    view_->show_mirror();
    view_->make_current();
    glFinish();
  }
  // Where the marker is in the window, from the lower left corner.
  Vec2 marker_in_window(PictureSize window) const {
    const MirrorPlace place = place_mirror(window, kEyePixels);
    const Vec2 eye = project_into_eye(mock_xr::eyes_at(2)[0], kHeadsetMarker);
    return {place.x_px + eye.x() * place.size.width_px / kEyePixels.width_px,
            place.y_px + eye.y() * place.size.height_px / kEyePixels.height_px};
  }
  void expect_mirror(int width, int height) {
    const Picture seen{{width, height}, person_->read_pixels(static_cast<unsigned>(width), static_cast<unsigned>(height))};
    ASSERT_EQ(seen.rgb.size(), static_cast<std::size_t>(3 * width * height));
    const auto found = centroid(seen, 0, 0, width);
    ASSERT_TRUE(found);
    EXPECT_LT((*found - marker_in_window({width, height})).norm(), 1.0);
  }

  std::unique_ptr<StereoView> view_;
  std::unique_ptr<Person> person_;
};

TEST_F(HeadsetMirror, TheLeftEyesPictureIsInTheMiddleOfTheWindow) { expect_mirror(640, 360); }

TEST_F(HeadsetMirror, AWindowOfAnotherSizeShowsItAsLargeAsFits) {
  person_->resize(300, 500);
  wait_until([&] {
    view_->poll_events();
    return view_->take_redraw_request();
  });
  EXPECT_EQ(view_->picture_size(), kEyePixels) << "the headset's pictures keep their size";
  draw_mirror();
  expect_mirror(300, 500);
}

TEST_F(HeadsetMirror, ThePointerPicksWhatIsUnderItInTheMirror) {
  const Vec2 at = marker_in_window({640, 360});
  person_->send_button(ButtonPress, Button1, static_cast<int>(at.x()), 359 - static_cast<int>(at.y()));
  std::vector<WindowEvent> received;
  wait_until([&] {
    for (const auto& event : view_->poll_events()) received.push_back(event);
    return !received.empty();
  });
  ASSERT_FALSE(received.empty());
  const auto p_W = view_->pick(received.front().x_px, received.front().y_px);
  ASSERT_TRUE(p_W) << received.front().x_px << ' ' << received.front().y_px;
  EXPECT_LT((*p_W - kHeadsetMarker).norm(), 0.011) << "on the marker";
}

}  // namespace
}  // namespace hapton
