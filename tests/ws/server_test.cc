// Tests requests over HTTP and their answers.

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/files.pb.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/drawing/inflate.h"
#include "server/service/wire/json.h"
#include "tests/ws/http_fixture.h"

namespace kerf::ws_test {
namespace {

TEST_F(HttpServerTest, ServesTheViewer) {
  start();
  const Response index = get("/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<p>viewer</p>");
  EXPECT_EQ(index.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(index.headers.at("cache-control"), "no-cache");
  EXPECT_EQ(index.headers.at("x-content-type-options"), "nosniff");
  EXPECT_TRUE(index.headers.contains("content-security-policy"));
  EXPECT_EQ(get("/?sheet=demo").body, index.body);
  const Response again = get("/", "If-None-Match: " + index.headers.at("etag") + "\r\n");
  EXPECT_EQ(again.status, 304);
  EXPECT_TRUE(again.body.empty());
  EXPECT_EQ(get("/", "If-None-Match: \"other\"\r\n").status, 200);
  const Response script = get("/assets/app-12.js");
  EXPECT_EQ(script.body, "let viewer;");
  EXPECT_EQ(script.headers.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_NE(script.headers.at("cache-control").find("immutable"), std::string::npos);
  const Response head = request(port_, "HEAD", "/");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), std::to_string(index.body.size()));
}

TEST_F(HttpServerTest, NoPathLeadsOutOfTheViewer) {
  folder_.write("kerf-secret.txt", "not for you");
  start();
  for (const char* path : {"/../kerf-secret.txt", "/..%2fkerf-secret.txt", "/%2e%2e/kerf-secret.txt",
                           "/assets/../../kerf-secret.txt", "//etc/passwd", "/..\\kerf-secret.txt", "/%00",
                           "/index.html%00.js", "http://127.0.0.1/../etc/passwd", "/assets/", "/assets"}) {
    const Response response = get(path);
    EXPECT_EQ(response.status, 404) << path;
    EXPECT_EQ(response.body.find("not for you"), std::string::npos) << path;
  }
}

TEST_F(HttpServerTest, ServesTheDocumentation) {
  folder_.write("kerf-secret.txt", "not for you");
  app::Config config = test_config();
  config.docs = folder_.write("docs/index.html", "<p>docs</p>").parent_path();
  folder_.write("docs/client/tutorial.html", "<p>tutorial</p>");
  folder_.write("docs/assets/site.js", "let docs;");
  start(config);
  const Response bare = get("/docs");
  EXPECT_EQ(bare.status, 302);
  EXPECT_EQ(bare.headers.at("location"), "docs/");
  const Response index = get("/docs/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<p>docs</p>");
  EXPECT_EQ(index.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(index.headers.at("cache-control"), "no-cache");
  EXPECT_EQ(index.headers.at("content-security-policy"), get("/").headers.at("content-security-policy"));
  EXPECT_EQ(get("/docs/", "If-None-Match: " + index.headers.at("etag") + "\r\n").status, 304);
  EXPECT_EQ(get("/docs/index.html").body, index.body);
  EXPECT_EQ(get("/docs/client/tutorial.html?highlight=cut").body, "<p>tutorial</p>");
  const Response script = get("/docs/assets/site.js");
  EXPECT_EQ(script.headers.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(script.headers.at("cache-control"), "no-cache") << "its name does not change with its content";
  EXPECT_EQ(get("/").body, "<p>viewer</p>");
  for (const char* path : {"/docs/../kerf-secret.txt", "/docs/..%2fkerf-secret.txt", "/docs/%2e%2e/kerf-secret.txt",
                           "/docs/client/../../kerf-secret.txt", "/docs//etc/passwd", "/docs/client/", "/docs/client",
                           "/docs/../index.html", "/docs/none.html", "/docsindex.html", "/docs/index.html/"}) {
    const Response response = get(path);
    EXPECT_EQ(response.status, 404) << path;
    EXPECT_EQ(response.body.find("not for you"), std::string::npos) << path;
  }
  EXPECT_EQ(request(port_, "POST", "/docs/").status, 404);
}

TEST_F(HttpServerTest, SaysHowToBuildTheDocumentation) {
  start();
  for (const char* path : {"/docs", "/docs/"}) {
    const Response none = get(path);
    EXPECT_EQ(none.status, 404) << path;
    EXPECT_EQ(none.headers.at("content-type"), "text/plain; charset=utf-8");
    EXPECT_NE(none.body.find("deploy/docs"), std::string::npos) << none.body;
  }
}

TEST_F(HttpServerTest, CallsMethodsWithJson) {
  start();
  v1::ServerInfo info;
  const Response told = call("ServerService/GetServerInfo", "");
  ASSERT_EQ(told.status, 200) << told.body;
  EXPECT_EQ(told.headers.at("content-type"), "application/json");
  ASSERT_TRUE(wire::from_json(told.body, info).ok());
  EXPECT_EQ(info.limits().max_request_bytes(), 1 << 20);
  EXPECT_EQ(info.renderer().rfind("none", 0), 0U) << info.renderer();

  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  v1::CutResult cut;
  const Response done = call("CutService/CreateCut",
                             R"({"parent":"sheets/a","cut":{"curve":{"polyline":{"points":[
                                 {"x":0.51,"y":-0.2},{"x":0.47,"y":1.2}]}}}})");
  ASSERT_EQ(done.status, 200) << done.body;
  ASSERT_TRUE(wire::from_json(done.body, cut).ok());
  EXPECT_EQ(cut.status(), v1::CutResult::APPLIED);
  EXPECT_EQ(cut.pieces(), 2);
}

TEST_F(HttpServerTest, TellsWhatIsWrongWithACall) {
  start();
  const Response unknown = call("SheetService/GetSheet", R"({"name":"sheets/none"})");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_NE(unknown.body.find("\"code\":5"), std::string::npos) << unknown.body;
  EXPECT_NE(unknown.body.find("SHEET_NOT_FOUND"), std::string::npos) << unknown.body;
  const Response refused = call("SheetService/CreateSheet", R"({"scene":{"grid":{"columns":1,"rows":6}}})");
  EXPECT_EQ(refused.status, 400);
  EXPECT_NE(refused.body.find("\"code\":3"), std::string::npos) << refused.body;
  EXPECT_NE(refused.body.find("scene.grid.columns"), std::string::npos) << refused.body;
  EXPECT_NE(refused.body.find("type.googleapis.com/google.rpc.BadRequest"), std::string::npos) << refused.body;
  EXPECT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  EXPECT_EQ(call("SheetService/CreateSheet", kSheet).status, 409);
  EXPECT_EQ(call("SheetService/GetSheet", "{").status, 400);
  EXPECT_EQ(call("SheetService/GetSheet", R"({"nom":"sheets/a"})").status, 400);
  EXPECT_EQ(call("SheetService/NoSuchMethod", "{}").status, 404);
  const Response get_method = get("/kerf.v1.SheetService/GetSheet");
  EXPECT_EQ(get_method.status, 405);
  EXPECT_EQ(get_method.headers.at("allow"), "POST");
  EXPECT_EQ(request(port_, "DELETE", "/index.html").status, 405);
}

TEST_F(HttpServerTest, LetsNoForeignPageCall) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  const std::string pause = R"({"name":"sheets/a"})";
  const std::string port = std::to_string(port_);
  for (const std::string& origin :
       {std::string("http://evil.example.org"), std::string("null"), std::string("http://127.0.0.1.evil.org"),
        std::string("http://localhost:1"), "https://127.0.0.1:" + port, "http://127.0.0.2:" + port}) {
    const Response refused = call("SheetService/ResumeSheet", pause, "Origin: " + origin + "\r\n");
    EXPECT_EQ(refused.status, 403) << origin;
    EXPECT_NE(refused.body.find("ORIGIN_NOT_ALLOWED"), std::string::npos) << refused.body;
  }
  EXPECT_EQ(call("SheetService/ResumeSheet", pause, "Host: rebound.example.org\r\n").status, 403);
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(call("SheetService/GetSheet", pause).body, sheet).ok());
  EXPECT_EQ(sheet.run_state(), v1::Sheet::PAUSED);
  EXPECT_EQ(call("SheetService/GetSheet", pause, "Origin: http://localhost:" + port + "\r\n").status, 200);
  EXPECT_EQ(get("/", "Host: rebound.example.org\r\n").status, 403);
  RawClient nameless(port_);
  nameless.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(nameless.read_response().status, 400);
  RawClient balancer(port_);
  balancer.send("GET /readyz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(balancer.read_response().status, 200);
}

TEST_F(HttpServerTest, BodiesEndAtTheLimit) {
  start();
  const std::size_t limit = std::size_t{1} << 20;
  const std::string padding(limit - 2, ' ');
  EXPECT_EQ(call("ServerService/GetServerInfo", "{" + padding + "}").status, 200);
  EXPECT_EQ(call("ServerService/GetServerInfo", "{ " + padding + "}").status, 413);
  RawClient chunked(port_);
  chunked.send(
      "POST /kerf.v1.ServerService/GetServerInfo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 17; ++i) chunked.send("10000\r\n" + std::string(65536, ' ') + "\r\n");
  EXPECT_EQ(chunked.read_response().status, 413);
  RawClient long_extension(port_);
  long_extension.send("POST /x HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n1;");
  for (int i = 0; i < 5 && long_extension.send(std::string(65536, 'x')); ++i) {
  }
  EXPECT_EQ(long_extension.read_response().status, 431) << "the extension of a chunk";
  RawClient oversized(port_);
  oversized.send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n");
  EXPECT_EQ(oversized.read_response().status, 413);
  EXPECT_EQ(get("/", "X-Long: " + std::string(17 << 10, 'x') + "\r\n").status, 431);
  EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(HttpServerTest, MeshFilesAreUploadedBeyondTheLimitOfAMessage) {
  start();
  std::string file;
  while (file.size() < (std::size_t{1} << 20) + 1) file += "# " + std::string(1000, 'x') + "\n";
  file += "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string target = "/sheets?format=obj&request=%7B%22sheet_id%22%3A%22large%22%2C%22paused%22%3Atrue%7D";
  const Response made = request(port_, "POST", target, {}, file);
  ASSERT_EQ(made.status, 200) << made.body;
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(made.body, sheet).ok());
  EXPECT_EQ(sheet.name(), "sheets/large");
  EXPECT_EQ(sheet.num_vertices(), 3);
  EXPECT_EQ(request(port_, "POST", target, {}, file).status, 409) << "there already";
  EXPECT_EQ(request(port_, "POST", "/sheets?format=stl", {}, file).status, 400);
  EXPECT_EQ(request(port_, "POST", "/sheets?format=obj&request=%7", {}, file).status, 400);
  EXPECT_EQ(request(port_, "POST", "/sheets?format=obj&request=%7B", {}, file).status, 400);
  EXPECT_EQ(request(port_, "POST", "/sheets?format=obj", {}, "").status, 400);
  EXPECT_EQ(request(port_, "POST", target, "Origin: http://elsewhere.example\r\n", file).status, 403)
      << "of whoever may not upload nothing is read";
  EXPECT_EQ(request(port_, "POST", target, "Origin: http://elsewhere.example\r\n", "v").status, 403);
  RawClient oversized(port_);
  oversized.send("POST /sheets?format=obj HTTP/1.1\r\nHost: localhost\r\nContent-Length: 67108865\r\n\r\n");
  EXPECT_EQ(oversized.read_response().status, 413);
}

TEST_F(HttpServerTest, MeshFilesAreInspectedBeyondTheLimitOfAMessage) {
  start();
  const std::string file = std::string(std::size_t{2} << 20, '\n') + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string target =
      "/meshes?format=obj&request=%7B%22obj%22%3A%7B%22reading%22%3A%7B%22unit_m%22%3A2%7D%7D%7D";
  const Response reply = request(port_, "POST", target, {}, file);
  ASSERT_EQ(reply.status, 200) << reply.body;
  v1::MeshReport report;
  ASSERT_TRUE(wire::from_json(reply.body, report).ok());
  EXPECT_EQ(report.num_triangles(), 1);
  EXPECT_EQ(report.area_m2(), 2.0) << "in units of 2 m";
  EXPECT_EQ(request(port_, "POST", "/meshes?format=obj", {}, drawing::gzipped(file)).status, 200);
  EXPECT_EQ(request(port_, "POST", "/meshes?format=ply", {}, file).status, 400);
  EXPECT_EQ(request(port_, "POST", "/meshes?format=stl", {}, file).status, 400);
  for (const char* const what : {"%7B%22ply%22%3A%7B%7D%7D", "%7B%22obj%22%3A%7B%22text%22%3A%22v%22%7D%7D"}) {
    const Response refused = request(port_, "POST", std::string("/meshes?format=obj&request=") + what, {}, file);
    EXPECT_EQ(refused.status, 400);
    EXPECT_NE(refused.body.find("UPLOAD_OF_WHAT"), std::string::npos) << refused.body;
  }
  EXPECT_EQ(request(port_, "POST", "/meshes?format=obj&request=%7B", {}, file).status, 400);
  EXPECT_EQ(request(port_, "POST", target, "Origin: http://elsewhere.example\r\n", file).status, 403);
  EXPECT_EQ(call("SheetService/ListSheets", "{}").body.find("sheets/"), std::string::npos) << "nothing was made";
  RawClient oversized(port_);
  oversized.send("POST /meshes?format=obj HTTP/1.1\r\nHost: localhost\r\nContent-Length: 67108865\r\n\r\n");
  EXPECT_EQ(oversized.read_response().status, 413);
}

TEST_F(HttpServerTest, RecordingsAreDownloadedAndPlayed) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  ASSERT_EQ(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":70})").status, 200);
  const Response file = get("/sheets/a.rec");
  ASSERT_EQ(file.status, 200);
  EXPECT_EQ(file.headers.at("content-type"), "application/octet-stream");
  EXPECT_EQ(file.headers.at("content-disposition"), "attachment; filename=\"a.rec\"");
  const Response made = request(port_, "POST", "/recordings?sheet=again&paused=true", {}, file.body);
  ASSERT_EQ(made.status, 200) << made.body;
  const Response stepped = call("SheetService/StepSheet", R"({"name":"sheets/again","ticks":1000})");
  v1::Sheet played, live;
  ASSERT_TRUE(wire::from_json(stepped.body, played).ok());
  ASSERT_TRUE(wire::from_json(call("SheetService/GetSheet", R"({"name":"sheets/a"})").body, live).ok());
  EXPECT_EQ(played.replay().state(), v1::Replay::DONE);
  EXPECT_EQ(played.state_hash(), live.state_hash());
  EXPECT_EQ(get("/sheets/nobody.rec").status, 404);
  EXPECT_EQ(get("/sheets/../a.rec").status, 400);
  EXPECT_EQ(get("/sheets/.rec").status, 400);
  EXPECT_EQ(request(port_, "POST", "/recordings?sheet=b", {}, "no recording").status, 400);
  EXPECT_EQ(request(port_, "POST", "/recordings?sheet=b&paused=maybe", {}, file.body).status, 400);
  RawClient rebound(port_);
  rebound.send("GET /sheets/a.rec HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(rebound.read_response().status, 403);
}

TEST_F(HttpServerTest, CountsWhatItDoes) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  EXPECT_EQ(metric("kerf_ticks_total"), 0.0);
  EXPECT_EQ(metric("kerf_sheets{state=\"paused\"}"), 1.0);
  ASSERT_EQ(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":5})").status, 200);
  EXPECT_EQ(metric("kerf_ticks_total"), 5.0);
  EXPECT_EQ(metric("kerf_tick_duration_seconds_count"), 5.0);
  EXPECT_EQ(metric("kerf_snapshots_total"), 0.0) << "nobody watches";
  const Response page = get("/metrics");
  EXPECT_EQ(page.headers.at("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  const std::regex line(
      R"(# (HELP|TYPE) (kerf|process)_[a-z_]+ .+|(kerf|process)_[a-z_]+(\{[a-z]+="[^"]*"\})? -?[0-9.+eE-]+)");
  std::istringstream lines(page.body);
  int counted = 0;
  for (std::string text; std::getline(lines, text); ++counted) EXPECT_TRUE(std::regex_match(text, line)) << text;
  EXPECT_GT(counted, 60);
}

}  // namespace
}  // namespace kerf::ws_test
