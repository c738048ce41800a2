// SPDX-License-Identifier: MIT
#include "bench/distribution.h"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <iterator>

namespace nlo::bench {

namespace {

// Blue and orange, which readers with common colour blindness can tell apart.
constexpr const char* kColours[] = {"#2f7de1", "#e07b1f"};

/// Returns a string literal of gnuplot, in which only a quote needs an escape.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

/// Returns a duration with a suitable unit.
std::string readable(double ns) {
  char text[32];
  if (ns < 1e3) {
    std::snprintf(text, sizeof text, "%.0f ns", ns);
  } else if (ns < 1e6) {
    std::snprintf(text, sizeof text, "%.3g us", 1e-3 * ns);
  } else {
    std::snprintf(text, sizeof text, "%.3g ms", 1e-6 * ns);
  }
  return text;
}

/// Prints lines "centre width share" of buckets that are an eighth of an octave wide: x in us, y the share of all
/// values.
void print_buckets(std::FILE* out, const Distribution& distribution) {
  const auto& values = distribution.values_ns();
  const double growth = std::exp2(0.125);
  double low = 1.0;
  for (auto first = values.begin(); first != values.end();) {
    const double high = low * growth;
    const auto last =
        std::find_if(first, values.end(), [high](std::int64_t v) { return static_cast<double>(v) >= high; });
    const auto share = static_cast<double>(last - first) / static_cast<double>(values.size());
    if (share > 0.0) std::fprintf(out, "%.6g %.6g %.6g\n", 0.5e-3 * (low + high), 1e-3 * (high - low), share);
    first = last;
    low = high;
  }
}

}  // namespace

std::string draw_histograms(const std::vector<HistogramPanel>& panels, const std::string& path) {
  std::signal(SIGPIPE, SIG_IGN);  // if gnuplot is missing, nobody reads the pipe
  std::FILE* gnuplot = popen("gnuplot", "w");
  if (gnuplot == nullptr) return "gnuplot cannot be started";
  std::fprintf(gnuplot,
               "set terminal svg size 860,%zu font 'sans-serif,13' background 'white' enhanced\nset output %s\n",
               280 * panels.size(), quoted(path).c_str());
  std::fprintf(
      gnuplot,
      "set multiplot layout %zu,1\nset logscale xy\nset format x '%%g'\nset format y '10^{%%L}'\n"
      "set ylabel 'share of all'\nset grid lc rgb '#dddddd'\nset key above left vertical Left reverse samplen 1.5\n"
      "set style fill solid 0.6 noborder\nset yrange [1e-7:1]\nset ytics 100\n",
      panels.size());
  for (std::size_t p = 0; p < panels.size(); ++p) {
    std::string plot;
    for (std::size_t d = 0; d < panels[p].distributions.size(); ++d) {
      const Distribution& distribution = *panels[p].distributions[d];
      const std::string block = "$d" + std::to_string(p) + '_' + std::to_string(d);
      std::fprintf(gnuplot, "%s << END\n", block.c_str());
      print_buckets(gnuplot, distribution);
      std::fprintf(gnuplot, "END\n");
      const std::string title = distribution.name() + ": median " + readable(distribution.quantile_ns(0.5)) +
                                ", 99.9 % " + readable(distribution.quantile_ns(0.999)) + ", longest " +
                                readable(distribution.quantile_ns(1.0));
      plot += (d == 0 ? "plot " : ", ") + block + " using 1:3:2 with boxes lc rgb '" +
              kColours[d % std::size(kColours)] + "' title " + quoted(title);
    }
    std::fprintf(gnuplot, "set xlabel %s offset 0,0.4\nset xrange [0.1:*]\n%s\n",
                 quoted(panels[p].title + "  [us]").c_str(), plot.c_str());
  }
  if (pclose(gnuplot) != 0) return "gnuplot is missing, or could not write " + path;
  return {};
}

}  // namespace nlo::bench
