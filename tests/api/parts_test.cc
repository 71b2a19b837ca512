// Files and pictures of sheets, and the parts that methods and streams are made of.

#include <array>
#include <atomic>
#include <future>
#include <new>
#include <optional>
#include <semaphore>
#include <set>
#include <sstream>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "render/renderer.h"
#include "server/service/api/core.h"
#include "server/service/host/wake_callback.h"
#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

TEST_F(ApiTest, SheetsAreExportedAsBinaryGltf) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::ExportSheetRequest request;
  request.set_name("sheets/a");
  request.set_format(v1::ExportSheetRequest::GLTF);
  std::promise<v1::ExportSheetResponse> promise;
  api_->export_sheet(request, [&promise](Result<v1::ExportSheetResponse> reply) { promise.set_value(reply.value()); });
  const v1::ExportSheetResponse response = promise.get_future().get();
  EXPECT_EQ(response.media_type(), "model/gltf-binary");
  EXPECT_EQ(response.content().substr(0, 4), "glTF");
}

TEST_F(ApiTest, ObjHoldsEveryTriangleWithMaterialOnce) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  v1::ExportSheetRequest request;
  request.set_name("sheets/a");
  Answers<v1::ExportSheetResponse> answers;
  std::promise<v1::ExportSheetResponse> promise;
  api_->export_sheet(request, [&promise](Result<v1::ExportSheetResponse> reply) { promise.set_value(reply.value()); });
  const v1::ExportSheetResponse response = promise.get_future().get();
  EXPECT_EQ(response.media_type(), "model/obj");
  std::istringstream lines(response.content());
  std::string line;
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<double, 2>> material;
  std::set<int> used;
  double area = 0.0;  // in material coordinates: that of the sheet, whatever was cut
  int faces = 0;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string keyword;
    words >> keyword;
    if (keyword == "v") {
      std::array<double, 3> p{};
      ASSERT_TRUE(words >> p[0] >> p[1] >> p[2]);
      positions.push_back(p);
    } else if (keyword == "vt") {
      std::array<double, 2> p{};
      ASSERT_TRUE(words >> p[0] >> p[1]);
      material.push_back(p);
    } else if (keyword == "f") {
      std::array<int, 3> corner{};
      for (int& index : corner) {
        std::string pair;
        words >> pair;
        index = std::stoi(pair);
        EXPECT_EQ(pair, std::to_string(index) + "/" + std::to_string(index));
        ASSERT_GE(index, 1);
        ASSERT_LE(index, static_cast<int>(positions.size()));
        used.insert(index);
      }
      const auto at = [&](int k) {
        return material[static_cast<std::size_t>(corner[static_cast<std::size_t>(k)] - 1)];
      };
      area += 0.5 * ((at(1)[0] - at(0)[0]) * (at(2)[1] - at(0)[1]) - (at(2)[0] - at(0)[0]) * (at(1)[1] - at(0)[1]));
      ++faces;
    } else {
      EXPECT_EQ(keyword, "#");
    }
  }
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(faces, sheet.num_triangles());
  EXPECT_EQ(positions.size(), material.size());
  EXPECT_EQ(used.size(), positions.size()) << "no vertex that no face uses";
  EXPECT_EQ(static_cast<int>(positions.size()), sheet.num_vertices());
  EXPECT_NEAR(area, 1.0, 1e-9);
}

// Notes what it is asked to draw; can be made to wait.
class FakeRenderer : public render::Renderer {
 public:
  render::Status render(const render::Scene& scene, const render::Camera& camera, int width, int height,
                        render::Pixels& pixels, render::RenderTimes*) override {
    started.release();
    if (blocked) go.acquire();
    num_triangles = scene.mesh.triangles.size() / 3;
    num_colliders = scene.colliders.size();
    eye_x = camera.eye.x;
    wireframe = scene.style.wireframe;
    background = scene.style.background;
    textured = scene.style.texture;
    positions.assign(scene.mesh.positions.begin(), scene.mesh.positions.end());
    looks.assign(scene.mesh.looks.begin(), scene.mesh.looks.end());
    fronts.clear();
    for (const render::Look& look : scene.style.looks) fronts.push_back(look.front.red);
    const render::Status status = render::validate(scene);
    if (!status.ok()) return status;
    pixels = {width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width * height), 200)};
    return {};
  }
  [[nodiscard]] bool available() const override { return true; }
  [[nodiscard]] std::string description() const override { return "fake"; }

  std::counting_semaphore<64> started{0};
  std::counting_semaphore<64> go{0};
  std::atomic<bool> blocked{false};
  std::size_t num_triangles = 0;
  std::size_t num_colliders = 0;
  double eye_x = 0.0;
  bool wireframe = false;
  render::Colour background;
  bool textured = false;
  std::vector<float> positions;
  std::vector<std::int32_t> looks;
  std::vector<double> fronts;  // Red of the front of each look.
};

Result<v1::RenderImageResponse> draw(Api& api, const v1::RenderImageRequest& request) {
  std::promise<Result<v1::RenderImageResponse>> promise;
  api.render_image(request, [&promise](Result<v1::RenderImageResponse> reply) { promise.set_value(std::move(reply)); });
  return promise.get_future().get();
}

TEST_F(ApiTest, PictureIsDrawnOffTheStrand) {
  if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
  FakeRenderer renderer;
  make_api({}, &renderer);
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  request.set_width_px(64);
  request.set_height_px(32);
  request.set_wireframe(true);
  request.mutable_camera()->mutable_eye()->set_x(3.0);
  request.mutable_camera()->mutable_target();
  Result<v1::RenderImageResponse> picture = draw(*api_, request);
  ASSERT_TRUE(picture.ok()) << picture.error().message;
  EXPECT_EQ(picture->media_type(), "image/png");
  EXPECT_EQ(picture->image().substr(1, 3), "PNG");
  EXPECT_EQ(picture->width_px(), 64);
  EXPECT_EQ(renderer.num_triangles, 72U);
  EXPECT_EQ(renderer.eye_x, 3.0);
  EXPECT_TRUE(renderer.wireframe);
  EXPECT_GT(renderer.background.red, 0.8);
  EXPECT_EQ(picture->strain_end(), 0.0);
  request.set_dark(true);
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_LT(renderer.background.red, 0.2);
  request.set_format(v1::RenderImageRequest::JPEG);
  picture = draw(*api_, request);
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->image().substr(0, 2), "\xff\xd8");
  request.set_name("sheets/nobody");
  EXPECT_EQ(draw(*api_, request).error().code, ErrorCode::kNotFound);
}

TEST_F(ApiTest, EachPartOfASheetIsDrawnAsItsMaterialLooksNow) {
  if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
  FakeRenderer renderer;
  make_api({}, &renderer);
  // Eight triangles: two, of the lower left square, of rubber.
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/CreateSheet",
                        R"({"sheet_id":"a","paused":true,"scene":{"material":{"preset":"silk"},"fidelity":"REAL_TIME",)"
                        R"("materials":[{"region":{"box":{"max":{"x":1,"y":1}}},"material":{"preset":"rubber"}}],)"
                        R"("grid":{"columns":3,"rows":3,"width_m":2,"height_m":2}}})")
                  .ok());
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  ASSERT_TRUE(draw(*api_, request).ok());
  ASSERT_EQ(renderer.looks.size(), 8U);
  ASSERT_EQ(renderer.fronts.size(), 2U);
  const int rubber = renderer.fronts[0] < renderer.fronts[1] ? 0 : 1;
  EXPECT_LT(renderer.fronts[static_cast<std::size_t>(rubber)], 0.3) << "black";
  EXPECT_GT(renderer.fronts[static_cast<std::size_t>(1 - rubber)], 0.4) << "silk is red";
  EXPECT_EQ(std::count(renderer.looks.begin(), renderer.looks.end(), rubber), 2);
  // A cut through the part divides its triangles, which stay what they are.
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.5)).ok());
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_GT(std::count(renderer.looks.begin(), renderer.looks.end(), rubber), 2);
  ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetMaterial",
                        R"({"name":"sheets/a","set_material":{"part":0,"material":{"preset":"paper"}}})")
                  .ok());
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_GT(renderer.fronts[static_cast<std::size_t>(rubber)], 0.7) << "paper is white";
}

TEST_F(ApiTest, ThePictureOfTheUndeformedSheetIsFlatAndWholeWherever) {
  if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
  FakeRenderer renderer;
  make_api({}, &renderer);
  // 2 m x 1 m, upright, too far away for a camera before it, with a ball.
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/CreateSheet",
                        R"({"sheet_id":"a","paused":true,"scene":{"placement":{"origin":{"y":1e6}},)"
                        R"("colliders":[{"sphere":{"center":{"y":1e6},"radius_m":1}}],)"
                        R"("grid":{"columns":5,"rows":3,"width_m":2,"height_m":1}}})")
                  .ok());
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  ASSERT_EQ(draw(*api_, request).error().reason, "SHEET_OUT_OF_REACH");
  request.set_undeformed(true);
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_EQ(renderer.num_colliders, 0U);
  EXPECT_EQ(renderer.positions.size(), 3U * 15U);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_EQ(renderer.positions[3 * i], 0.5F * static_cast<float>(i % 5)) << i;
    EXPECT_EQ(renderer.positions[3 * i + 1], 0.5F * static_cast<float>(i / 5)) << i;
    EXPECT_EQ(renderer.positions[3 * i + 2], 0.0F) << i;
  }
  // Straight down on its middle.
  EXPECT_NEAR(renderer.eye_x, 1.0, 1e-6);
  EXPECT_TRUE(renderer.textured);
  request.set_wireframe(true);
  request.mutable_camera()->mutable_eye()->set_x(0.3);
  request.mutable_camera()->mutable_eye()->set_y(-2.0);
  request.mutable_camera()->mutable_target();
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_EQ(renderer.eye_x, 0.3);
  EXPECT_FALSE(renderer.textured) << "triangles are drawn on plain colour";
  request.set_undeformed(false);
  ASSERT_TRUE(draw(*api_, request).ok());
  EXPECT_EQ(renderer.num_colliders, 1U);
  EXPECT_TRUE(renderer.textured);
}

TEST_F(ApiTest, ASheetOutOfReachIsNotTheCamerasFault) {
  FakeRenderer renderer;
  make_api({}, &renderer);
  const auto create = [this](const std::string& id, const std::string& origin) {
    return call_json("/kerf.v1.SheetService/CreateSheet",
                     R"({"sheet_id":")" + id + R"(","paused":true,"scene":{"placement":{"origin":)" + origin +
                         R"(},"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})");
  };
  ASSERT_TRUE(create("beyond", R"({"x":1e6})").ok());                // reaches out by its width
  ASSERT_TRUE(create("edge", R"({"y":-1e6})").ok());                 // the camera would stand beyond
  ASSERT_TRUE(create("within", R"({"x":-9.9e5,"y":-9.9e5})").ok());  // far, and drawn
  v1::RenderImageRequest request;
  for (const char* name : {"sheets/beyond", "sheets/edge"}) {
    request.set_name(name);
    const Result<v1::RenderImageResponse> picture = draw(*api_, request);
    ASSERT_FALSE(picture.ok()) << name;
    EXPECT_EQ(picture.error().code, ErrorCode::kFailedPrecondition);
    EXPECT_EQ(picture.error().reason, "SHEET_OUT_OF_REACH");
    EXPECT_EQ(picture.error().field, "");
  }
  if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
  request.set_name("sheets/within");
  EXPECT_TRUE(draw(*api_, request).ok());
  request.set_name("sheets/edge");
  request.mutable_camera()->mutable_eye()->set_y(-9e5);
  request.mutable_camera()->mutable_target()->set_y(-1e6);
  EXPECT_TRUE(draw(*api_, request).ok()) << "by a camera that stands within reach";
  request.set_name("sheets/beyond");
  EXPECT_EQ(draw(*api_, request).error().reason, "SHEET_OUT_OF_REACH");
}

TEST_F(ApiTest, WaitingPicturesAreBoundedAndRefusedAtTheEnd) {
  FakeRenderer renderer;
  renderer.blocked = true;
  Limits limits;
  limits.max_waiting_pictures = 2;
  make_api(limits, &renderer);
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  Answers<v1::RenderImageResponse> answers;
  api_->render_image(request, answers.callback());
  renderer.started.acquire();  // it is being drawn now
  for (int i = 0; i < 3; ++i) api_->render_image(request, answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.at(0).error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(get_sheet("sheets/a").tick(), 0) << "the sheet answers while a picture is drawn";
  v1::ExportSheetRequest exported;
  exported.set_name("sheets/a");
  std::promise<bool> is_made;
  api_->export_sheet(exported, [&is_made](const auto& file) { is_made.set_value(file.ok()); });
  EXPECT_TRUE(is_made.get_future().get()) << "files are made while a picture is drawn";
  renderer.blocked = false;
  renderer.go.release(4);
  api_.reset();
  EXPECT_EQ(answers.count(), 4U) << "drawn or refused, but answered";
}

TEST(InBackground, WorkThatThrowsIsAnsweredOnceAndTheNextIsDone) {
  picture::BackgroundWorker worker(8);
  std::promise<void> last;
  Answers<int> answers;
  const Error full{ErrorCode::kResourceExhausted, "FULL", "", ""};
  in_background<int>(
      worker, answers.callback(), []() -> Result<int> { throw std::bad_alloc(); }, full);
  in_background<int>(
      worker, answers.callback(), []() -> Result<int> { throw std::runtime_error("a bug of ours"); }, full);
  in_background<int>(
      worker,
      [callback = answers.callback(), &last](Result<int> result) {
        callback(std::move(result));
        last.set_value();
      },
      [] { return 3; }, full);
  last.get_future().wait();
  worker.stop();
  ASSERT_EQ(answers.count(), 3U);
  EXPECT_EQ(answers.at(0).error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(answers.at(0).error().reason, "OUT_OF_MEMORY");
  EXPECT_EQ(answers.at(1).error().code, ErrorCode::kInternal);
  EXPECT_EQ(answers.at(1).error().message, "a bug of ours");
  EXPECT_EQ(answers.at(2).value(), 3);
}

TEST_F(ApiTest, WhatThrowsWhileASheetIsLookedAtIsAnswered) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const auto core = std::make_shared<ApiCore>(*host_, nullptr, ApiOptions(), clock_);
  Answers<int> answers;
  inspect<int>(
      core, "a", [](const sheet::Sheet&) -> int { throw std::bad_alloc(); }, "name", answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.at(0).error().reason, "OUT_OF_MEMORY");
  EXPECT_EQ(get_sheet("sheets/a").tick(), 0);
}

TEST(WakeCallback, TakingItAwayWaitsForACallUnderWay) {
  host::WakeCallback wake;
  std::atomic<bool> inside{false};
  std::atomic<bool> may_return{false};
  std::atomic<bool> returned{false};
  wake.set([&] {
    inside = true;
    inside.notify_all();
    may_return.wait(false);
    returned = true;
  });
  std::thread caller([&] { wake.call(); });
  inside.wait(false);
  std::thread liberator([&] {
    may_return = true;
    may_return.notify_all();
  });
  wake.set({});
  EXPECT_TRUE(returned);
  wake.call();  // No callback is set.
  caller.join();
  liberator.join();
}

TEST(WakeCallback, CanBeTakenAwayFromWithinItself) {
  host::WakeCallback wake;
  int calls = 0;
  wake.set([&] {
    ++calls;
    wake.set({});
  });
  wake.call();
  wake.call();
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace kerf::api
