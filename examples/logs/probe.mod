%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE ProbeRef
  ! Touches on the reference fixture, recorded with SearchL: targets relative to wRef; tProbe ends at the ball's centre
  PERS tooldata tProbe:=[TRUE,[[0,0,182.4],[1,0,0,0]],[0.6,[0,0,60],[1,0,0,0],0,0,0]];
  CONST jointtarget jHome:=[[0,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS robtarget p1:=[[2.927,2,1.625],[0,0.707107,0.707107,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];PERS robtarget p2:=[[1.775,2.8,1.4438],[0,0.707107,0.707107,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS robtarget p3:=[[1.373,2.6,3.1166],[0,0.707107,0.707107,0],
    [0,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL PERS robtarget p4:=[[3.527,3.2,3.1082],[0,0.707107,0.707107,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS pos plane_touch{3}:=[[2.825,2.4,4.0395],
                            [3.902,5.2,4.0353], ! second
                            [2.048,5.2,4.7853]];
  VAR robtarget pNext;

  PROC main()
    MoveAbsJ jHome,v200,fine,tProbe;
    SearchL \Stop,diProbe,p1,p1,v10,tProbe\WObj:=wRef;
    TPWrite "touched; p1 stored";
  ENDPROC
ENDMODULE
