// scorer_soak: feeds paths to a scorer and writes its scores and chords.
//
// Standard input has batches of 32-bit words: `gives_up`, one of how many cycles the streams pause
// in (0: none), paths, points, the words of the problem, and those of the points. Standard output
// gets the cycles from the first point to the last score, then for each path its score and the
// cycle in which it was offered, then for each waypoint three words of its chord.

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

static bool read(Word* words, std::size_t count) {
    return std::fread(words, sizeof *words, count, stdin) == count;
}

static void write(const std::vector<Word>& words) {
    std::fwrite(words.data(), sizeof(Word), words.size(), stdout);
}

int main() {
    VerilatedContext context;
    Vtop chip{&context, ""};
    Word random = 1;
    Word header[4];
    chip.rst = 0;
    while (read(header, 4)) {
        const auto [gives_up, pause, paths, count] = header;
        std::vector<Word> points(2 * count);
        chip.gives_up = gives_up;
        if (!read(&chip.problem[0], sizeof chip.problem / sizeof(Word))) return 1;
        if (!read(points.data(), points.size())) return 1;

        const auto draws = [&] {
            random = random * 1664525 + 1013904223;
            return pause == 0 || (random >> 8) % pause != 0;
        };
        const std::size_t waypoints = count - 2 * paths;
        std::vector<Word> scores, chords;
        std::size_t taken = 0;
        Word cycles = 0;
        bool valid = false;
        while (scores.size() < 2 * paths || chords.size() < 3 * waypoints) {
            valid = taken < count && (valid || draws());
            chip.points___05Fvalid = valid;
            if (valid) {
                chip.points___05Fpayload =
                    points[2 * taken] | static_cast<std::uint64_t>(points[2 * taken + 1]) << 32;
            }
            chip.scores___05Fready = draws();
            chip.chords___05Fready = draws();
            chip.clk = 0;
            chip.eval();
            ++cycles;
            if (chip.points___05Fvalid && chip.points___05Fready) {
                ++taken;
                valid = false;
            }
            if (chip.scores___05Fvalid && chip.scores___05Fready) {
                scores.push_back(chip.scores___05Fpayload);
                scores.push_back(cycles);
            }
            if (chip.chords___05Fvalid && chip.chords___05Fready) {
                append(chords, chip.chords___05Fpayload);
            }
            chip.clk = 1;
            chip.eval();
            if (cycles > 400 * (count + 100)) return 2;
        }
        write({cycles});
        write(scores);
        write(chords);
    }
    chip.final();
    return 0;
}
