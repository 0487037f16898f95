# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
#
# The steps of docs/install.md in a container with ROS 2 Jazzy:
#
#     docker build -t heading_intercompare . && docker run --rm heading_intercompare
#     docker stop --time 60 CONTAINER    # as Ctrl-C: the last run is judged, the bag is closed
FROM ros:jazzy-ros-base
SHELL ["/bin/bash", "-c"]
WORKDIR /workspace
COPY . src/heading_intercompare
# pip installs what has no package of Ubuntu into the virtual environment below.
RUN apt-get update \
 && apt-get install --yes --no-install-recommends python3-pip python3-venv \
 && rosdep update --rosdistro jazzy \
 && rosdep install --rosdistro jazzy --from-paths src --ignore-src --yes \
        --dependency-types exec --skip-keys mcap-ros2-support \
 && rm -rf /var/lib/apt/lists/*
RUN . /opt/ros/jazzy/setup.bash \
 && python3 -m venv --system-site-packages .venv && . .venv/bin/activate && touch .venv/COLCON_IGNORE \
 && python3 -m pip install mcap lz4 zstandard \
 && python3 -m colcon build --packages-select heading_intercompare && . install/setup.bash
# `ros2 launch` ends in order on SIGINT, not on SIGTERM. `exec` makes it the process that gets the
# signal, and without a terminal it passes it on to the nodes.
STOPSIGNAL SIGINT
CMD . .venv/bin/activate && . install/setup.bash \
 && exec ros2 launch heading_intercompare demo.launch.py --noninteractive
