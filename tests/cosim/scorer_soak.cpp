// scorer_soak: feeds paths to a scorer and writes its scores and chords.
//
// Standard input has batches of 32-bit words: one of how many cycles points and room pause in (0:
// none), paths, points, segments, the words of the problem, and the words of the points. Standard
// output gets, for each path, the cycle of its launch, its score and the cycle of that, then for
// each segment the cycle of its record and three words of that.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <verilated.h>

#include "Vtop.h"

using Word = std::uint32_t;

// Words of a port of up to 64 bits, and of a wider one.
static void append(std::vector<Word>& to, std::uint64_t value) {
    to.push_back(static_cast<Word>(value));
    to.push_back(static_cast<Word>(value >> 32));
    to.push_back(0);
}

template <std::size_t N>
static void append(std::vector<Word>& to, const VlWide<N>& value) {
    for (std::size_t i = 0; i < 3; ++i) to.push_back(i < N ? value[i] : 0);
}

static bool is_valid(std::uint64_t value) { return value & 1; }

template <std::size_t N>
static bool is_valid(const VlWide<N>& value) {
    return value[0] & 1;
}

static bool read(Word* words, std::size_t count) {
    return std::fread(words, sizeof *words, count, stdin) == count;
}

static void write(const std::vector<Word>& words) {
    std::fwrite(words.data(), sizeof(Word), words.size(), stdout);
}

int main() {
    VerilatedContext context;
    Vtop chip{&context, ""};
    Word random = 1, cycle = 0;
    Word header[4];
    chip.rst = 0;
    while (read(header, 4)) {
        const auto [pause, paths, count, segments] = header;
        std::vector<Word> points(2 * count);
        if (!read(&chip.problem[0], sizeof chip.problem / sizeof(Word))) return 1;
        if (!read(points.data(), points.size())) return 1;

        const auto draws = [&] {
            random = random * 1664525 + 1013904223;
            return pause == 0 || (random >> 8) % pause != 0;
        };
        std::vector<Word> launches, scores, chords;
        std::size_t taken = 0;
        bool valid = false;
        const Word first = cycle;
        while (scores.size() < 2 * paths) {
            valid = taken < count && (valid || draws());
            chip.points___05Fvalid = valid;
            if (valid) {
                chip.points___05Fpayload =
                    points[2 * taken] | static_cast<std::uint64_t>(points[2 * taken + 1]) << 32;
            }
            chip.room = draws();
            chip.phase = cycle & 1;
            chip.clk = 0;
            chip.eval();
            if (chip.points___05Fvalid && chip.points___05Fready) {
                ++taken;
                valid = false;
            }
            if (chip.launches) launches.push_back(cycle);
            if (is_valid(chip.chord)) {
                chords.push_back(cycle);
                append(chords, chip.chord);
            }
            if (is_valid(chip.score)) {
                scores.push_back(chip.score);
                scores.push_back(cycle);
            }
            chip.clk = 1;
            chip.eval();
            if (++cycle - first > 400 * (count + 100)) return 2;
        }
        if (launches.size() != paths || chords.size() != 4 * segments) return 3;
        write(launches);
        write(scores);
        write(chords);
    }
    chip.final();
    return 0;
}
