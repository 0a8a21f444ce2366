// seed_source_soak: feeds problems to a source of seeds and writes its findings.
//
// Standard input has jobs of 32-bit words: `load` (a new map follows), corners written, `scan`,
// limit, paths, words of the random source, one of how many cycles words pause in (0: none), and whether seeds are at turns; then the words of the problem and of the frame; the map's
// corners; those to be written (x, y, altitude); and the random words. Standard output gets for each
// job the cycles of the scan, of the launch and of all paths, passes, blocks and turns of the route, waypoints,
// words taken; then blocks of the map (two words each), surfaces, costs, the route, room for its turns, and waypoints (two words).

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <vector>

#include <verilated.h>

#include "Vtop.h"
#include "Vtop___024root.h"

using Word = std::uint32_t;
constexpr std::size_t BLOCKS = 4096;

static std::vector<Word> output;

static bool read(std::vector<Word>& words) {
    return std::fread(words.data(), sizeof(Word), words.size(), stdin) == words.size();
}

static void append(std::uint64_t value) {
    output.push_back(static_cast<Word>(value));
    output.push_back(static_cast<Word>(value >> 32));
}

int main() {
    VerilatedContext context;
    Vtop chip{&context, ""};
    chip.rst = 0;
    std::vector<Word> header(8), ground(SIZE * SIZE);
    Word random = 1;
    const auto* const root = chip.rootp;
    while (read(header)) {
        const Word load = header[0], writes = header[1], scan = header[2], pause = header[6];
        std::vector<Word> problem(sizeof chip.problem / sizeof(Word)), frame(sizeof chip.frame / sizeof(Word));
        std::vector<Word> written(3 * writes), drawn(header[5]);
        if (!read(problem) || !read(frame)) return 1;
        if (load) {
            if (!read(ground)) return 1;
            chip.rst = 1;
            chip.clk = 0;
            chip.eval();
            chip.clk = 1;
            chip.eval();
            chip.rst = 0;
        }
        if (!read(written) || !read(drawn)) return 1;
        for (std::size_t i = 0; i < problem.size(); ++i) chip.problem[i] = problem[i];
        std::memcpy(&chip.frame, frame.data(), sizeof chip.frame);
        chip.limit = header[3];
        chip.by_turns = header[7];

        const auto draws = [&] {
            random = random * 1664525 + 1013904223;
            return pause == 0 || (random >> 8) % pause != 0;
        };
        std::deque<Word> rows(LATENCY, 0);
        std::vector<std::uint64_t> waypoints;
        std::size_t taken = 0;
        const auto cycle = [&] {
            chip.word = taken < drawn.size() ? drawn[taken] : 0;
            chip.word_ready = taken < drawn.size() && draws();
            const std::size_t at = rows.front();
            Word corners[LANES];
            for (int i = 0; i < LANES; ++i) corners[i] = ground[at * LANES + i];
            SET_CORNERS
            chip.clk = 0;
            chip.eval();
            rows.pop_front();
            rows.push_back(chip.row);
            taken += chip.step;
            if (chip.found & 1) waypoints.push_back(chip.found);
            chip.clk = 1;
            chip.eval();
        };
        for (std::size_t i = 0; i < writes; ++i) {
            const Word x = written[3 * i], y = written[3 * i + 1];
            ground[y * SIZE + x] = written[3 * i + 2];
            chip.write = 1 | x << 1 | y << (1 + COORDINATE_BITS);
            cycle();
        }
        chip.write = 0;
        if (writes == 0) cycle();  // Blocks of start and goal.
        const auto run = [&](CData& pulse) {
            pulse = 1;
            cycle();
            pulse = 0;
            Word cycles = 0;
            while (chip.busy) {
                cycle();
                if (++cycles > 1000000) std::exit(2);
            }
            return cycles;
        };
        const Word scanned = scan ? run(chip.scan) : 0;
        const Word ran = run(chip.launch);
        const Word length = root->LENGTH;
        Word seeded = 0;
        for (Word i = 0; i < header[4]; ++i) seeded += run(chip.begin);
        for (int i = 0; i < 32; ++i) cycle();  // The last waypoints.
        output = {scanned, ran, seeded, chip.passes, length, static_cast<Word>(root->TURNS),
                  static_cast<Word>(waypoints.size()), static_cast<Word>(taken)};
        for (std::size_t i = 0; i < BLOCKS; ++i) append(root->RECORDS[i]);
        for (std::size_t i = 0; i < BLOCKS; ++i) output.push_back(root->SURFACES[i]);
        for (std::size_t i = 0; i < BLOCKS; ++i) output.push_back(root->COSTS[i]);
        for (std::size_t i = 0; i < length; ++i) output.push_back(root->PLACES[i]);
        for (std::size_t i = 0; i < MOST_TURNS; ++i) output.push_back(root->STORED_TURNS[i]);
        for (const auto each : waypoints) append(each);
        std::fwrite(output.data(), sizeof(Word), output.size(), stdout);
    }
    chip.final();
    return 0;
}
