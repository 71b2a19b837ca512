// Shows a live sheet in the terminal: terminal_viewer [SHEET [HOST:PORT [TOKEN_FILE [FILE_OF_AUTHORITIES]]]]. The
// picture follows the window's size; q or Ctrl-C quits.

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <sys/ioctl.h>
#include <unistd.h>

#include <kerf/client.h>

// Draws two pixels per character: the upper one in the text colour, the lower one in the background colour. Surfaces
// that face the light are brighter.
bool draw(const kerf::client::Mirror& mirror) {
  winsize window{24, 80, 0, 0};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &window);
  const int width = window.ws_col, height = 2 * window.ws_row - 2;
  static const kerf::v1::Box3 box = mirror.box();  // From the first frame, so that the camera keeps still.
  const double x0 = (box.min().x() + box.max().x()) / 2, z0 = (box.min().z() + box.max().z()) / 2;
  const double scale = std::min(width / (box.max().x() - x0), height / (box.max().z() - z0)) / 3;  // Pixels per metre.
  std::vector<double> depth(std::size_t(width * height), INFINITY);
  std::vector<int> pixels(depth.size(), 234);  // The terminal has 256 colours; 232..255 are greys.
  for (const auto& [i, j, k] : mirror.triangles()) {
    if (i < 0) continue;  // No material.
    const auto a = mirror.position(i), b = mirror.position(j), c = mirror.position(k);
    const double u[] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double n[] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double light = std::abs(n[0] - n[1] + n[2]) / (std::hypot(n[0], n[1], n[2]) + 1e-12) / std::sqrt(3.0);
    const int steps = 1 + int(1.5 * scale * std::max(std::hypot(u[0], u[1], u[2]), std::hypot(v[0], v[1], v[2])));
    for (int step = 0; step < steps * steps; ++step) {
      const double s = double(step % steps) / steps, t = (1 - s) * (step / steps) / steps;
      const double y = a[1] + s * u[1] + t * v[1];  // Away from the viewer.
      const int column = int(width / 2 + scale * (a[0] + s * u[0] + t * v[0] - x0 + 0.3 * y));
      const int row = int(height / 2 - scale * (a[2] + s * u[2] + t * v[2] - z0 + 0.2 * y));
      const std::size_t pixel = std::size_t(row * width + column);
      if (column < 0 || column >= width || row < 0 || row >= height || y >= depth[pixel]) continue;
      depth[pixel] = y;
      pixels[pixel] = 238 + int(17.9 * light);
    }
  }
  std::printf("\033[H");
  for (int row = 0; row < height; row += 2)
    for (int *pixel = &pixels[std::size_t(row * width)], *end = pixel + width; pixel < end; ++pixel)
      std::printf("\033[38;5;%d;48;5;%dm▀", pixel[0], pixel[width]);
  std::printf("\033[0m tick %lld, pieces %d; q quits\033[K", static_cast<long long>(mirror.tick()),
              mirror.num_pieces());
  return std::fflush(stdout) == 0;
}

int main(int argc, char** argv) {
  const auto at = [&](int i, const char* usual) { return std::string(argc > i ? argv[i] : usual); };
  kerf::client::Server server(at(2, "127.0.0.1:50051"), {.credentials{.token_file = at(3, ""), .tls_ca = at(4, "")}});
  kerf::client::Watcher watcher(server.client());
  // Makes read() wait a tenth of a second for a key. Ctrl-C is one, 3, so that the terminal is restored before the end.
  if (std::system("stty -icanon -echo -isig min 0 time 1") != 0) return 2;
  std::atomic<bool> live = true;
  std::thread keys([&] {
    for (char key = 0; live && key != 'q' && key != 3 && read(STDIN_FILENO, &key, 1) >= 0;) continue;
    watcher.stop();
  });
  const auto end = watcher.run("sheets/" + at(1, "demo"), {.max_rate_hz = 30},
                               [](const auto& /*frame*/, const auto& mirror) { return draw(mirror); });
  live = false;
  keys.join();
  if (!end.ok()) std::fprintf(stderr, "%s\n", describe(kerf::client::failure_of(end)).c_str());
  return std::system("stty icanon echo isig") != 0 || !end.ok();
}
