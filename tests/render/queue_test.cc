#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <set>
#include <thread>
#include <tuple>
#include <utility>

#include "render/null_renderer.h"
#include "render/threaded_renderer.h"

namespace kerf::render {
namespace {

// Holds the observations and behaviour of the canvases of a test.
struct Studio {
  std::mutex mutex;
  std::set<std::thread::id> threads;  // that made, used or destroyed a canvas
  int num_made = 0;
  int num_drawn = 0;
  int num_alive = 0;
  std::vector<Status> next_outcomes;  // of the next draws, last first; ok when empty
  std::vector<Status> next_makings;   // Results of making the next canvases.
  std::latch* begun = nullptr;        // counted down by each draw
  std::latch* go_on = nullptr;        // waited for by each draw

  void saw_thread() { threads.insert(std::this_thread::get_id()); }
};

Status take(std::vector<Status>& outcomes) {
  if (outcomes.empty()) return {};
  Status outcome = outcomes.back();
  outcomes.pop_back();
  return outcome;
}

class FakeCanvas final : public Canvas {
 public:
  explicit FakeCanvas(Studio& studio) : studio_(studio) {
    const std::lock_guard lock(studio_.mutex);
    ++studio_.num_alive;
  }
  ~FakeCanvas() override {
    const std::lock_guard lock(studio_.mutex);
    studio_.saw_thread();
    --studio_.num_alive;
  }

  Status draw(const DrawList& list, Pixels& pixels, RenderTimes* times) override {
    if (times != nullptr) std::tie(times->draw_s, times->read_s) = std::pair(0.25, 0.125);
    if (studio_.begun != nullptr) studio_.begun->count_down();
    if (studio_.go_on != nullptr) studio_.go_on->wait();
    const std::lock_guard lock(studio_.mutex);
    studio_.saw_thread();
    ++studio_.num_drawn;
    pixels.width = list.width;
    pixels.height = list.height;
    return take(studio_.next_outcomes);
  }
  [[nodiscard]] std::string description() const override { return "a fake"; }
  [[nodiscard]] bool draws_in_software() const override { return true; }

 private:
  Studio& studio_;
};

CanvasFactory factory(Studio& studio) {
  return [&studio](std::unique_ptr<Canvas>& canvas, std::vector<DeviceOutcome>& outcomes) {
    outcomes = {{{"card", "", DeviceKind::kHardware}, DeviceState::kRejected, "on fire"},
                {{"easel", "", DeviceKind::kSoftware}, DeviceState::kChosen, "a fake"},
                {{"spare", "", DeviceKind::kSoftware}, DeviceState::kNotTried, ""}};
    Status outcome;
    {
      const std::lock_guard lock(studio.mutex);
      studio.saw_thread();
      ++studio.num_made;
      outcome = take(studio.next_makings);
    }
    if (outcome.ok()) canvas = std::make_unique<FakeCanvas>(studio);
    return outcome;
  };
}

Status render(Renderer& renderer, int width = 64) {
  Pixels pixels;
  Status status = renderer.render(Scene{}, Camera{}, width, 48, pixels);
  if (status.ok()) {
    EXPECT_EQ(pixels.width, width);
  } else {
    EXPECT_EQ(pixels.width, 0);
  }
  return status;
}

const Status kLost{StatusCode::kUnavailable, "CONTEXT_LOST", "gone", ""};

TEST(RenderQueue, OneThreadDoesAllTheDrawing) {
  Studio studio;
  {
    ThreadedRenderer renderer(factory(studio), {});
    EXPECT_TRUE(renderer.available());
    EXPECT_EQ(renderer.description(), "easel, a fake; not card: on fire");
    EXPECT_EQ(renderer.devices().size(), 3U);
    std::vector<std::thread> callers;
    for (int caller = 0; caller < 4; ++caller) {
      callers.emplace_back([&renderer, caller] {
        for (int round = 0; round < 10; ++round) EXPECT_TRUE(render(renderer, 64 + caller).ok());
      });
    }
    for (std::thread& caller : callers) caller.join();
  }
  EXPECT_EQ(studio.num_made, 1);
  EXPECT_EQ(studio.num_drawn, 40);
  EXPECT_EQ(studio.num_alive, 0);
  EXPECT_EQ(studio.threads.size(), 1U);
  EXPECT_FALSE(studio.threads.contains(std::this_thread::get_id()));
}

TEST(RenderQueue, RefusesWhenTooManyWait) {
  Studio studio;
  std::latch begun(1);
  std::latch go_on(1);
  ThreadedRenderer renderer(factory(studio), {.max_waiting = 0});
  studio.begun = &begun;
  studio.go_on = &go_on;
  std::thread first([&renderer] { EXPECT_TRUE(render(renderer).ok()); });
  begun.wait();
  const Status refused = render(renderer);
  EXPECT_EQ(refused.code, StatusCode::kResourceExhausted);
  EXPECT_EQ(refused.reason, "RENDER_QUEUE_FULL");
  go_on.count_down();
  first.join();
  studio.begun = nullptr;
  EXPECT_TRUE(render(renderer).ok()) << "there is room again";
}

TEST(RenderQueue, TellsWhereTheTimeWent) {
  Studio studio;
  ThreadedRenderer renderer(factory(studio), {});
  Pixels pixels;
  RenderTimes times{-1.0, -1.0, -1.0, -1.0};
  ASSERT_TRUE(renderer.render(Scene{}, Camera{}, 64, 48, pixels, &times).ok());
  EXPECT_GE(times.prepare_s, 0.0);
  EXPECT_GE(times.wait_s, 0.0);
  EXPECT_EQ(times.draw_s, 0.25);
  EXPECT_EQ(times.read_s, 0.125);
  studio.next_outcomes = {kLost};
  ASSERT_FALSE(renderer.render(Scene{}, Camera{}, 64, 48, pixels, &times).ok());
  EXPECT_EQ(times.draw_s, 0.25) << "of the last picture that was drawn";
}

TEST(RenderQueue, ALostContextIsAnErrorAndTheNextCallGetsAFreshOne) {
  Studio studio;
  ThreadedRenderer renderer(factory(studio), {});
  studio.next_outcomes = {kLost};
  const Status lost = render(renderer);
  EXPECT_EQ(lost.code, StatusCode::kUnavailable);
  EXPECT_EQ(lost.reason, "CONTEXT_LOST");
  EXPECT_EQ(studio.num_alive, 0);
  EXPECT_TRUE(render(renderer).ok());
  EXPECT_EQ(studio.num_made, 2);

  studio.next_outcomes = {kLost};
  EXPECT_FALSE(render(renderer).ok());
  studio.next_makings = {kLost};
  EXPECT_EQ(render(renderer).reason, "CONTEXT_LOST") << "no new context yet";
  EXPECT_TRUE(render(renderer).ok());
  EXPECT_EQ(studio.threads.size(), 1U);
}

TEST(RenderQueue, SaysWhyThereIsNoCanvas) {
  Studio studio;
  studio.next_makings = {{StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", "no device", ""}};
  const ThreadedRenderer renderer(factory(studio), {});
  EXPECT_FALSE(renderer.available());
  EXPECT_EQ(renderer.description(), "none: no device");
}

TEST(RenderQueue, WaitingCallsAreAnsweredWhenItShutsDown) {
  Studio studio;
  std::latch begun(1);
  std::latch go_on(1);
  std::atomic<int> num_refused = 0;
  {
    ThreadedRenderer renderer(factory(studio), {.max_waiting = 2});
    studio.begun = &begun;
    studio.go_on = &go_on;
    std::vector<std::thread> callers;
    callers.emplace_back([&renderer] { EXPECT_TRUE(render(renderer).ok()) << "it was being drawn"; });
    begun.wait();
    studio.begun = nullptr;
    for (int caller = 0; caller < 2; ++caller) {
      callers.emplace_back([&renderer, &num_refused] {
        if (render(renderer).reason == "SHUTTING_DOWN") ++num_refused;
      });
    }
    while (renderer.num_calls() < 3) std::this_thread::yield();
    renderer.stop();
    EXPECT_EQ(render(renderer).reason, "SHUTTING_DOWN");
    go_on.count_down();
    for (std::thread& caller : callers) caller.join();
  }
  EXPECT_EQ(num_refused, 2);
  EXPECT_EQ(studio.num_drawn, 1);
  EXPECT_EQ(studio.num_alive, 0);
}

TEST(RenderQueue, ChecksArgumentsBeforeAnythingIsQueued) {
  Studio studio;
  ThreadedRenderer renderer(factory(studio), {});
  EXPECT_EQ(render(renderer, kMaxImageSize + 1).field, "width");
  EXPECT_EQ(studio.num_drawn, 0);
}

TEST(NullRenderer, SaysSoAndGoesOn) {
  const std::unique_ptr<Renderer> renderer = make_null_renderer("no EGL here");
  EXPECT_FALSE(renderer->available());
  EXPECT_EQ(renderer->description(), "none: no EGL here");
  const Status status = render(*renderer);
  EXPECT_EQ(status.code, StatusCode::kUnavailable);
  EXPECT_EQ(status.reason, "RENDERER_UNAVAILABLE");
  EXPECT_NE(status.message.find("no EGL here"), std::string::npos);
  EXPECT_EQ(render(*renderer, 0).field, "width") << "bad arguments are told first";
}

}  // namespace
}  // namespace kerf::render
