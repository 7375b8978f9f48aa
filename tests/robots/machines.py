"""Robots written for the tests."""

# ruff: noqa: E501

from __future__ import annotations

ARM = """
<robot name="arm">
  <link name="base"><inertial><mass value="9"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="l1">
    <inertial><origin xyz="0.01 -0.02 0.11" rpy="0.3 -0.2 0.5"/><mass value="4.1"/>
      <inertia ixx="0.031" ixy="0.001" ixz="-0.002" iyy="0.029" iyz="0.0005" izz="0.012"/></inertial>
    <visual><origin xyz="0 0 0.1" rpy="0 0.2 0"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></visual>
  </link>
  <link name="l2">
    <inertial><origin xyz="0.2 0.01 0.03" rpy="0 1.1 0.2"/><mass value="5.2"/>
      <inertia ixx="0.012" ixy="0.001" ixz="0.003" iyy="0.091" iyz="-0.0005" izz="0.093"/></inertial>
    <visual><geometry><box size="0.4 0.06 0.08"/></geometry></visual>
  </link>
  <link name="l3">
    <inertial><origin xyz="0.15 0 0.02"/><mass value="2.6"/>
      <inertia ixx="0.006" iyy="0.031" izz="0.029" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="l4">
    <inertial><origin xyz="0 0 0.02" rpy="0.1 0.1 0.1"/><mass value="1.3"/>
      <inertia ixx="0.003" iyy="0.0025" izz="0.0015" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="l5">
    <inertial><origin xyz="0 0.02 0"/><mass value="0.9"/>
      <inertia ixx="0.0012" iyy="0.0011" izz="0.0009" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.04"/></geometry></visual>
  </link>
  <link name="l6">
    <inertial><origin xyz="0.03 0 0.05"/><mass value="0.4"/>
      <inertia ixx="0.0004" iyy="0.0005" izz="0.0003" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="tool">
    <inertial><origin xyz="0 0.01 0.04" rpy="0.4 0 0"/><mass value="0.7"/>
      <inertia ixx="0.0008" iyy="0.0007" izz="0.0004" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="tcp"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 0 1"/><limit lower="-2.9" upper="2.9" velocity="3" effort="200"/>
    <dynamics damping="0.5" friction="0.3"/></joint>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/>
    <origin xyz="0.05 0.02 0.25" rpy="0 -0.4 0"/><axis xyz="0 1 0"/><limit lower="-1.5" upper="2.0" velocity="3" effort="200"/></joint>
  <joint name="j3" type="revolute"><parent link="l2"/><child link="l3"/>
    <origin xyz="0.4 0 0.03" rpy="0.1 0.9 -0.2"/><axis xyz="0 1 0.1"/><limit lower="-2.2" upper="2.2" velocity="3" effort="100"/></joint>
  <joint name="j4" type="continuous"><parent link="l3"/><child link="l4"/>
    <origin xyz="0.3 0 0" rpy="1.57 0 1.57"/></joint>
  <joint name="j5" type="revolute"><parent link="l4"/><child link="l5"/>
    <origin xyz="0 0 0.08"/><axis xyz="0.2 -1 0"/><limit lower="-1.9" upper="1.9" velocity="4" effort="50"/></joint>
  <joint name="j6" type="revolute"><parent link="l5"/><child link="l6"/>
    <origin xyz="0 0 0.07" rpy="0 0 0.3"/><axis xyz="0 0 -1"/><limit lower="-3" upper="3" velocity="6" effort="20"/></joint>
  <joint name="flange" type="fixed"><parent link="l6"/><child link="tool"/>
    <origin xyz="0 0 0.06" rpy="0.2 0.1 -0.3"/></joint>
  <joint name="tip" type="fixed"><parent link="tool"/><child link="tcp"/><origin xyz="0.01 0 0.1" rpy="0 1.2 0"/></joint>
</robot>
"""

SCARA = """
<robot name="scara">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="6"/>
    <inertia ixx="0.02" iyy="0.09" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.14 0 0.02" rpy="0 0.1 0"/><mass value="4"/>
    <inertia ixx="0.01" iyy="0.05" izz="0.055" ixz="0.004" ixy="0" iyz="0"/></inertial></link>
  <link name="quill"><inertial><origin xyz="0 0 -0.1"/><mass value="1.1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.0006" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="spindle"><inertial><origin xyz="0.02 0 -0.02"/><mass value="0.6"/>
    <inertia ixx="0.0006" iyy="0.0007" izz="0.0004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 0 1"/><limit lower="-2.4" upper="2.4" velocity="6" effort="100"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0.4 0 0.05"/><axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" velocity="9" effort="60"/></joint>
  <joint name="lift" type="prismatic"><parent link="fore"/><child link="quill"/>
    <origin xyz="0.28 0 0"/><axis xyz="0 0 -1"/><limit lower="0" upper="0.2" velocity="1" effort="200"/></joint>
  <joint name="spin" type="continuous"><parent link="quill"/><child link="spindle"/>
    <origin xyz="0 0 -0.2"/><axis xyz="0 0 1"/></joint>
</robot>
"""

GRIPPER = """
<robot name="gripper">
  <link name="body"><inertial><origin xyz="0.02 0.01 0.3" rpy="0.1 0.2 0.3"/><mass value="12"/>
    <inertia ixx="0.3" iyy="0.25" izz="0.2" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0 0 -0.2"/><mass value="3"/>
    <inertia ixx="0.05" iyy="0.05" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0.01 0 -0.05"/><mass value="0.8"/>
    <inertia ixx="0.002" iyy="0.0018" izz="0.0009" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left"><inertial><origin xyz="0 0.01 -0.03"/><mass value="0.1"/>
    <inertia ixx="6e-5" iyy="6e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><origin xyz="0 -0.01 -0.03"/><mass value="0.12"/>
    <inertia ixx="6e-5" iyy="6e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tail"><inertial><origin xyz="-0.1 0 0.05"/><mass value="1.5"/>
    <inertia ixx="0.003" iyy="0.012" izz="0.013" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="body"/><child link="arm"/>
    <origin xyz="0 0.2 0.5" rpy="0.2 0 0"/><axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="6" effort="100"/></joint>
  <joint name="wrist" type="continuous"><parent link="arm"/><child link="hand"/>
    <origin xyz="0 0 -0.4" rpy="0 0 1"/><axis xyz="0 1 1"/></joint>
  <joint name="slide1" type="prismatic"><parent link="hand"/><child link="left"/>
    <origin xyz="0 0.02 -0.1"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="40"/></joint>
  <joint name="slide2" type="prismatic"><parent link="hand"/><child link="right"/>
    <origin xyz="0 -0.02 -0.1"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="40"/></joint>
  <joint name="wag" type="revolute"><parent link="body"/><child link="tail"/>
    <origin xyz="-0.1 0 0.1" rpy="0 0.3 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="6" effort="10"/></joint>
</robot>
"""

CREATURE = """
<mujoco model="creature">
  <compiler angle="degree" eulerseq="zyx"/>
  <option gravity="0.1 0 -9.7"><flag contact="disable"/></option>
  <default>
    <geom density="800"/>
    <joint damping="0.1" armature="0.02"/>
    <default class="thin"><geom type="capsule" size="0.03" density="500"/>
      <default class="finger"><joint type="slide" axis="0 1 0" range="-0.1 0.1" armature="0"/></default></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="trunk" pos="0 0 1" euler="10 20 30">
      <freejoint name="root"/>
      <geom type="box" size="0.2 0.1 0.15" pos="0.02 0 0"/>
      <geom type="sphere" size="0.08" pos="0 0 0.2" mass="1.5"/>
      <site name="eye" pos="0.1 0 0.2" axisangle="0 1 0 45"/>
      <body name="leg" pos="0.1 0.1 -0.1" quat="0.9 0.1 -0.2 0.3" childclass="thin">
        <joint name="hip" type="ball" pos="0 0.01 0.02"/>
        <geom fromto="0 0 0 0.05 0 -0.4"/>
        <body name="foot" pos="0.05 0 -0.4" xyaxes="1 0.1 0 0 1 0">
          <joint name="roll" axis="1 0 0" range="-40 30" pos="0 0 0.02"/>
          <joint name="pitch" axis="0 1 0.2" range="-50 60"/>
          <geom type="ellipsoid" size="0.1 0.05 0.03" pos="0.05 0 -0.02" euler="5 0 0"/>
        </body>
      </body>
      <body name="arm" pos="0 -0.2 0.1" zaxis="0 1 1">
        <joint name="shoulder" type="hinge" axis="1 2 0" springref="20" stiffness="3"/>
        <inertial pos="0.1 0.02 0" euler="0 0 40" mass="2" diaginertia="0.02 0.03 0.04"/>
        <frame pos="0.3 0 0" euler="0 90 0">
          <body name="left" childclass="finger"><joint name="lf"/><geom size="0.02 0.1"/></body>
          <body name="right"><joint name="rf" class="finger"/><geom class="thin" type="cylinder" size="0.02 0.1"/></body>
        </frame>
        <body name="plate" pos="0.1 0 0"><geom type="box" fromto="0 0 0 0 0.2 0.1" size="0.01"/></body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""

SCARA_SDF = """
<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity><model name="scara">
  <frame name="column"><pose>0 0 0.4 0 0 0</pose></frame>
  <link name="upper"><pose relative_to="column">0 0 0 0 0 0</pose>
    <inertial><pose>0.2 0 0 0 0 0</pose><mass>6</mass><inertia><ixx>0.02</ixx><iyy>0.09</iyy><izz>0.1</izz></inertia></inertial></link>
  <link name="fore"><pose relative_to="upper">0.4 0 0.05 0 0 0</pose>
    <inertial><pose degrees="true">0.14 0 0.02 0 5.729577951308232 0</pose><mass>4</mass>
    <inertia><ixx>0.01</ixx><iyy>0.05</iyy><izz>0.055</izz><ixz>0.004</ixz></inertia></inertial></link>
  <link name="quill"><pose>0.68 0 0.45 0 0 0.5</pose>
    <inertial><pose rotation_format="quat_xyzw">0 0 -0.1 0 0 -0.24740395925452294 0.9689124217106447</pose><mass>1.1</mass>
    <inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.0006</izz></inertia></inertial></link>
  <link name="spindle"><pose relative_to="lift">0 0 -0.2 0 0 0</pose>
    <inertial><pose>0.02 0 -0.02 0 0 0</pose><mass>0.6</mass><inertia><ixx>0.0006</ixx><iyy>0.0007</iyy><izz>0.0004</izz></inertia></inertial>
    <visual name="v"><pose>0 0 -0.1 0 0 0</pose><geometry><cylinder><radius>0.01</radius><length>0.2</length></cylinder></geometry></visual></link>
  <frame name="tip" attached_to="spindle"><pose>0 0 -0.2 0 0 0</pose></frame>
  <joint name="shoulder" type="revolute"><parent>world</parent><child>upper</child><axis><xyz>0 0 1</xyz>
    <limit><lower>-2.4</lower><upper>2.4</upper><effort>100</effort></limit></axis></joint>
  <joint name="elbow" type="revolute"><parent>upper</parent><child>fore</child><pose>0 0 0.3 0 1.2 0</pose>
    <axis><xyz expressed_in="__model__">0 0 1</xyz></axis></joint>
  <joint name="lift" type="prismatic"><parent>fore</parent><child>quill</child><pose>0 0 0 0 0 -0.5</pose><axis><xyz>0 0 -1</xyz>
    <limit><lower>0</lower><upper>0.2</upper></limit></axis></joint>
  <joint name="spin" type="continuous"><parent>quill</parent><child>spindle</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></world></sdf>
"""

WORKS = """
<mujoco model="works">
  <compiler settotalmass="30" balanceinertia="true"/>
  <option gravity="0 0 -9.81"><flag contact="disable"/></option>
  <default><position kp="20"/><mesh scale="1 1 2"/><default class="b"><joint ref="10"/></default></default>
  <asset><mesh name="m" vertex="0 0 0 .3 0 0 0 .2 0 0 0 .7" inertia="shell"/></asset>
  <worldbody>
    <body name="crank" gravcomp="0.5"><joint name="a" axis="0 1 0" springdamper="0.1 1"/><geom type="mesh" mesh="m"/>
      <body name="rod" pos="0 0 .2"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .5 0 .2" size=".01"/><site name="tip" pos=".5 0 .2"/></body></body>
    <body name="rocker" pos=".5 0 0"><joint name="c" axis="0 1 0"/><geom type="cylinder" size=".01 .2" shellinertia="true"/><site name="top" pos="0 0 .4"/></body>
    <body name="hub" pos="2 0 0"><joint name="spin"/><geom size=".1"/>
      <replicate count="3" euler="0 0 120"><body name="blade" pos=".2 0 0" childclass="b"><joint name="pitch" axis="1 0 0"/><geom type="box" mesh="m"/></body></replicate></body>
    <attach body="rocker" prefix="other "/>
  </worldbody>
  <equality><connect name="pin" site1="tip" site2="top"/><weld body1="hub" body2="other rocker" active="false"/><joint joint1="spin" polycoef="0.2"/></equality>
  <actuator><position name="servo" joint="a" dampratio="1"/><general joint="pitch" gear="2"/><velocity joint="c" kv="3"/></actuator>
</mujoco>
"""

NESTED_SDF = """
<sdf version="1.9"><model name="m">
  <link name="arm"><inertial><mass>1</mass></inertial></link>
  <model name="tool"><pose relative_to="arm">0.4 0 0.1 0 0.3 0</pose>
    <link name="body"><gravity>false</gravity><inertial><mass>2</mass></inertial></link><link name="tip"><inertial><mass>3</mass></inertial></link>
    <joint name="turn" type="screw"><parent>body</parent><child>tip</child><screw_thread_pitch>0.1</screw_thread_pitch></joint></model>
  <joint name="base" type="revolute"><parent>world</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
  <joint name="flange" type="revolute"><parent>arm</parent><child>tool::body</child><axis><xyz>1 0 0</xyz></axis></joint>
  <link name="wheel"><inertial><mass>1</mass></inertial></link>
  <joint name="axle" type="revolute"><parent>arm</parent><child>wheel</child><axis><xyz>1 0 0</xyz></axis></joint>
  <joint name="gear" type="gearbox"><parent>wheel</parent><child>tool::body</child><gearbox_reference_body>arm</gearbox_reference_body><gearbox_ratio>2</gearbox_ratio></joint>
</model></sdf>
"""
