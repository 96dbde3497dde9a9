#include "vision_node/eye_composer.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "tests/vision_node/made_views.h"
#include "vision_node/display.h"
#include "vision_node/window_picture.h"

namespace hapton {
namespace {

// A window whose background is a gradient between two colours, which differ for each eye.
struct TwoColours : testing::Test {
  void SetUp() override {
    auto display = DisplayConnection::open();
    ASSERT_TRUE(display) << display.error().what;
    window->SetDisplayId(display->id());
    window->SetMultiSamples(0);
    window->SetSize(kWidth, kHeight);
    window->ShowWindowOff();
    window->UseOffScreenBuffersOn();
    vtkNew<vtkCallbackCommand> begin;
    begin->SetClientData(this);
    begin->SetCallback([](vtkObject*, unsigned long, void* self, void*) { static_cast<TwoColours*>(self)->paint(); });
    renderer->AddObserver(vtkCommand::StartEvent, begin);
    renderer->GradientBackgroundOn();
    window->AddRenderer(renderer);
    opengl = vtkOpenGLRenderWindow::SafeDownCast(window);
    ASSERT_TRUE(opengl);
    opengl->Initialize();
  }
  void paint() {
    const bool is_left = uses_composer ? is_first_eye : renderer->GetActiveCamera()->GetLeftEye() != 0;
    const double shift = 0.13 * round + (is_left ? 0.0 : 0.41);
    const auto wrapped = [](double x) { return x - std::floor(x); };
    renderer->SetBackground(wrapped(shift), wrapped(3.0 * shift), wrapped(0.5 + 2.0 * shift));
    renderer->SetBackground2(wrapped(0.7 + shift), wrapped(0.2 + shift), wrapped(0.9 + 5.0 * shift));
  }
  Picture compose_by_vtk(int type) {
    uses_composer = false;
    window->SetStereoType(type);
    window->StereoRenderOn();
    window->Render();
    return read_window_picture(window);
  }
  Picture compose(EyeComposer& composer, bool has_colours) {
    uses_composer = true;
    window->StereoRenderOff();
    const PictureSize size{kWidth, kHeight};
    is_first_eye = true;
    window->Render();
    composer.keep_first_eye(opengl->GetRenderFramebuffer()->GetFBOIndex(), size);
    is_first_eye = false;
    window->Render();
    composer.compose(opengl->GetRenderFramebuffer()->GetFBOIndex(), size, has_colours);
    return read_window_picture(window);
  }

  static constexpr int kWidth = 64;
  static constexpr int kHeight = 256;
  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkOpenGLRenderWindow* opengl = nullptr;
  bool uses_composer = false;
  bool is_first_eye = true;
  int round = 0;
};

TEST_F(TwoColours, EyesAreComposedExactlyAsByVtk) {
  auto composer = EyeComposer::make();
  ASSERT_TRUE(composer) << composer.error().what;
  for (round = 0; round < 20; ++round) {
    for (const bool has_colours : {false, true}) {
      const Picture expected = compose_by_vtk(has_colours ? VTK_STEREO_ANAGLYPH : VTK_STEREO_RED_BLUE);
      const Picture ours = compose(**composer, has_colours);
      ASSERT_EQ(ours.rgb.size(), expected.rgb.size());
      ASSERT_TRUE(ours.rgb == expected.rgb) << "round " << round << ", colours " << has_colours;
    }
  }
  window->MakeCurrent();
}

// A view composes in the same way: its picture is equal to one that is composed here from those of the two eyes.
TEST(ComposedView, HasTheRedOfOneEyeAndTheBlueOfTheOther) {
  const std::vector<ShownObject> ball = {{make_marker(Vec3(0.01, 0, 0.02), 0.04), {0.6, 0.5, 0.2}}};
  const auto picture_in = [&](StereoMode mode) {
    ViewSettings settings = plain_settings(mode, 320, 240);
    settings.plain = false;
    auto view = open_or_fail(settings, ball);
    view->draw();
    view->draw();
    return view->read_picture();
  };
  const Picture left = picture_in(StereoMode::left);
  const Picture right = picture_in(StereoMode::right);
  const Picture both = picture_in(StereoMode::red_blue);
  ASSERT_EQ(both.rgb.size(), left.rgb.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < both.rgb.size(); i += 3) {
    const int grey_left = (left.rgb[i] + left.rgb[i + 1] + left.rgb[i + 2]) / 3;
    const int grey_right = (right.rgb[i] + right.rgb[i + 1] + right.rgb[i + 2]) / 3;
    differing += both.rgb[i] != grey_left || both.rgb[i + 1] != 0 || both.rgb[i + 2] != grey_right;
  }
  EXPECT_EQ(differing, 0U);
  EXPECT_FALSE(left.rgb == right.rgb);
}

}  // namespace
}  // namespace hapton
